# innergs_install(<library or Python module>...): where `cmake --install` puts them, found by each other wherever the prefix
# is moved. What was not built is left out.
set(INNERGS_PYTHON_DIR "${CMAKE_INSTALL_LIBDIR}/innergs/python" CACHE STRING "Folder of Python modules below the prefix")

function(innergs_install)
  foreach(target ${ARGN})
    get_target_property(type ${target} TYPE)
    set(folder "${CMAKE_INSTALL_LIBDIR}")
    if(type STREQUAL MODULE_LIBRARY)
      set(folder "${INNERGS_PYTHON_DIR}")
    endif()
    file(RELATIVE_PATH libraries "/${folder}" "/${CMAKE_INSTALL_LIBDIR}")
    if(APPLE)
      set_target_properties(${target} PROPERTIES INSTALL_RPATH "@loader_path/${libraries}")
    else()
      set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries}")
    endif()
    # Python looks for DLLs beside its modules.
    install(TARGETS ${target} LIBRARY DESTINATION ${folder} OPTIONAL RUNTIME DESTINATION ${INNERGS_PYTHON_DIR} OPTIONAL
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} OPTIONAL)
  endforeach()
endfunction()
