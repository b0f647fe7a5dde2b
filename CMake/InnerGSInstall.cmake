# Install locations for `cmake --install`. Skips what was not built.
include(CMakePackageConfigHelpers)
set(INNERGS_PYTHON_DIR "${CMAKE_INSTALL_LIBDIR}/innergs/python" CACHE STRING "Folder of Python modules below the prefix")
set(INNERGS_CMAKE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/InnerGS" CACHE STRING "Folder of InnerGSConfig.cmake below the prefix")

# innergs_install(<library or Python module>...): they find each other wherever the prefix is moved.
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
    get_target_property(export ${target} INNERGS_EXPORT)
    set(arguments "")
    if(export)
      set(arguments EXPORT InnerGS${export}Targets)
    endif()
    # Python looks for DLLs beside its modules.
    install(TARGETS ${target} ${arguments} LIBRARY DESTINATION ${folder} OPTIONAL RUNTIME DESTINATION ${INNERGS_PYTHON_DIR} OPTIONAL
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} OPTIONAL)
  endforeach()
endfunction()

# innergs_install_library(<component> <library> [<header>...]): the library, its headers and the target InnerGS::<component> for
# find_package(InnerGS). Call it before a folder's other install rules: if the library was not built, they are skipped too. Not
# for Slicer's libraries from PyPI, whose users have no such folder tree.
function(innergs_install_library component library)
  if(INNERGS_SLICER_CORE)
    get_target_property(type ${library} TYPE)
    if(type STREQUAL SHARED_LIBRARY)
      innergs_install(${library})
    endif()
    return()
  endif()
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${component} INNERGS_EXPORT ${component})
  install(CODE "if(NOT EXISTS \"$<TARGET_FILE:${library}>\")\n  return()\nendif()")
  innergs_install(${library})
  install(EXPORT InnerGS${component}Targets NAMESPACE InnerGS:: DESTINATION ${INNERGS_CMAKE_DIR})
  file(RELATIVE_PATH folder "${PROJECT_SOURCE_DIR}/Logic" "${CMAKE_CURRENT_SOURCE_DIR}")
  foreach(header IN LISTS ARGN) # a header given by relative path keeps its subfolder
    set(subfolder "")
    if(NOT IS_ABSOLUTE "${header}")
      get_filename_component(subfolder "${header}" DIRECTORY)
    endif()
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/innergs/${folder}/${subfolder})
  endforeach()
endfunction()

if(NOT INNERGS_SLICER_CORE)
  configure_package_config_file(CMake/InnerGSConfig.cmake.in "${CMAKE_CURRENT_BINARY_DIR}/InnerGSConfig.cmake"
    INSTALL_DESTINATION ${INNERGS_CMAKE_DIR} NO_SET_AND_CHECK_MACRO)
  write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/InnerGSConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
  install(FILES "${CMAKE_CURRENT_BINARY_DIR}/InnerGSConfig.cmake" "${CMAKE_CURRENT_BINARY_DIR}/InnerGSConfigVersion.cmake"
    DESTINATION ${INNERGS_CMAKE_DIR})
endif()
