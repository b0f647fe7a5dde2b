# innergs_wrap_python(<name> TARGET <library> HEADERS <absolute paths> MODULES <VTK modules> [TYPES <hierarchy files>])
#
# A Python extension module of the library's VTK classes, made by VTK's own wrapping tools: VTK::WrapHierarchy, VTK::WrapPython,
# VTK::WrapPythonInit. It is written to <build>/python. The library property INNERGS_HIERARCHY names a file with the library's
# classes; pass it as TYPES for a library that builds on this one. In a Slicer build, Slicer's vtkMacroKitPythonWrap does this
# instead, under the same module name.
function(innergs_wrap_python name)
  cmake_parse_arguments(ARG "" "TARGET" "HEADERS;MODULES;TYPES" ${ARGN})
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/${name}")
  file(MAKE_DIRECTORY "${folder}")

  # The base classes of VTK's own classes.
  set(types ${ARG_TYPES})
  foreach(module ${ARG_MODULES})
    get_target_property(file ${module} INTERFACE_vtk_module_hierarchy)
    list(APPEND types "${file}")
  endforeach()

  # Include folders and definitions of the library, for the tools' parser.
  set(definitions "$<TARGET_PROPERTY:${ARG_TARGET},COMPILE_DEFINITIONS>")
  set(includes "$<TARGET_PROPERTY:${ARG_TARGET},INCLUDE_DIRECTORIES>")
  file(GENERATE OUTPUT "${folder}/hierarchy.$<CONFIG>.args" CONTENT
"$<$<BOOL:${definitions}>:-D'$<JOIN:${definitions},'\n-D'>'>
$<$<BOOL:${includes}>:-I'$<JOIN:${includes},'\n-I'>'>
")
  set(hierarchy "${folder}/${ARG_TARGET}-hierarchy.txt")
  set_target_properties(${ARG_TARGET} PROPERTIES INNERGS_HIERARCHY "${hierarchy}")
  set(lines "")
  set(classes "")
  foreach(header ${ARG_HEADERS})
    string(APPEND lines "${header};${name}\n")
    get_filename_component(class "${header}" NAME_WE)
    list(APPEND classes ${class})
  endforeach()
  file(GENERATE OUTPUT "${folder}/headers.data" CONTENT "${lines}")
  add_custom_command(OUTPUT "${hierarchy}"
    COMMAND VTK::WrapHierarchy "@${folder}/hierarchy.$<CONFIG>.args" -o "${hierarchy}" "${folder}/headers.data" ${types}
    DEPENDS ${ARG_HEADERS} "${folder}/headers.data" "${folder}/hierarchy.$<CONFIG>.args" ${types}
    COMMENT "Listing the classes of ${ARG_TARGET}" VERBATIM)

  list(TRANSFORM types PREPEND "--types;" OUTPUT_VARIABLE type_options)
  set(sources "")
  foreach(header class IN ZIP_LISTS ARG_HEADERS classes)
    add_custom_command(OUTPUT "${folder}/${class}Python.cxx"
      COMMAND VTK::WrapPython "@${folder}/hierarchy.$<CONFIG>.args" --types "${hierarchy}" ${type_options}
        -o "${folder}/${class}Python.cxx" "${header}"
      DEPENDS "${header}" "${hierarchy}" "${folder}/hierarchy.$<CONFIG>.args"
      COMMENT "Wrapping ${class}" VERBATIM)
    list(APPEND sources "${folder}/${class}Python.cxx")
  endforeach()

  # First the module's name, then the classes, then the modules to import first.
  set(depends "")
  foreach(module ${ARG_MODULES})
    string(REPLACE "VTK::" "vtkmodules.vtk" package "${module}")
    list(APPEND depends ${package})
  endforeach()
  string(REPLACE ";" "\n" class_lines "${classes}")
  string(REPLACE ";" "\n" depend_lines "${depends}")
  file(GENERATE OUTPUT "${folder}/init.data" CONTENT "${name}\n${class_lines}\nDEPENDS\n${depend_lines}\n")
  set(init_sources "${folder}/${name}Init.cxx")
  if(VTK_VERSION VERSION_LESS 9.5) # later versions write a single file
    list(APPEND init_sources "${folder}/${name}InitImpl.cxx")
  endif()
  add_custom_command(OUTPUT ${init_sources}
    COMMAND VTK::WrapPythonInit "${folder}/init.data" ${init_sources}
    DEPENDS "${folder}/init.data" COMMENT "Wrapping the module ${name}" VERBATIM)

  add_library(${name} MODULE ${sources} ${init_sources})
  target_link_libraries(${name} PRIVATE ${ARG_TARGET} VTK::WrappingPythonCore VTK::Python)
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden
    LIBRARY_OUTPUT_DIRECTORY "$<1:${PROJECT_BINARY_DIR}/python>")
  if(WIN32)
    set_target_properties(${name} PROPERTIES SUFFIX ".pyd")
  endif()
endfunction()
