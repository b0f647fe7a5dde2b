# innergs_slicer_library(<name> EXPORT <directive> CLASSES <VTK classes> SOURCES <others> LIBRARIES <with PUBLIC, PRIVATE>)
#
# In a Slicer extension: a shared library of VTK classes in Slicer's module folder, and its Python module <name>Python, built by
# Slicer's own macros.
macro(innergs_slicer_library name)
  cmake_parse_arguments(LIB "" "EXPORT" "CLASSES;SOURCES;LIBRARIES" ${ARGN})
  set(lib_sources "")
  foreach(class ${LIB_CLASSES})
    list(APPEND lib_sources ${class}.cxx)
  endforeach()
  set_source_files_properties(${LIB_SOURCES} PROPERTIES SKIP_HEADER_INSTALL 1 WRAP_EXCLUDE 1 WRAP_EXCLUDE_PYTHON 1)
  SlicerMacroBuildModuleVTKLibrary(NAME ${name} EXPORT_DIRECTIVE ${LIB_EXPORT} SRCS ${lib_sources} ${LIB_SOURCES}
    INCLUDE_DIRECTORIES ${Slicer_Libs_INCLUDE_DIRS} ${Slicer_Base_INCLUDE_DIRS} ${Slicer_ModuleLogic_INCLUDE_DIRS}
      ${Slicer_ModuleMRML_INCLUDE_DIRS}
    TARGET_LIBRARIES ${LIB_LIBRARIES})
  target_include_directories(${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}> $<BUILD_INTERFACE:${CMAKE_CURRENT_BINARY_DIR}>)
  target_compile_definitions(${name} PRIVATE INNERGS_VERSION="${PROJECT_VERSION}")
  set_property(GLOBAL APPEND PROPERTY SLICER_MODULE_LOGIC_TARGETS ${name})
  if(Slicer_USE_PYTHONQT)
    SlicerMacroPythonWrapModuleVTKLibrary(NAME ${name} SRCS ${lib_sources})
    set_target_properties(${name}Python PROPERTIES
      RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/${Slicer_QTLOADABLEMODULES_BIN_DIR}"
      LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/${Slicer_QTLOADABLEMODULES_LIB_DIR}"
      ARCHIVE_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/${Slicer_QTLOADABLEMODULES_LIB_DIR}")
    set_property(GLOBAL APPEND PROPERTY Slicer_TARGETS ${name}Python)
  endif()
endmacro()
