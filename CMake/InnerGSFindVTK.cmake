# VTK 9.1 or later for Logic/VTK, and its Python wrapping tools. If something is missing, says so and continues without.
find_package(VTK 9.1 QUIET COMPONENTS CommonCore CommonDataModel CommonExecutionModel CommonMath CommonTransforms
  OPTIONAL_COMPONENTS ImagingCore WrappingPythonCore Python WrappingTools)
if(NOT VTK_FOUND OR NOT TARGET VTK::CommonExecutionModel)
  message(STATUS "VTK 9.1 or later was not found: the VTK filters are not built (Debian: libvtk9-dev; or set VTK_DIR)")
  return()
endif()
message(STATUS "VTK ${VTK_VERSION}: building the VTK filters")
if(INNERGS_SANITIZE) # an interpreter without the sanitizer cannot load instrumented modules
  set(INNERGS_WRAP_PYTHON OFF)
elseif(INNERGS_WRAP_PYTHON AND NOT (TARGET VTK::WrapPython AND TARGET VTK::WrappingPythonCore AND TARGET VTK::Python))
  message(STATUS "VTK's Python wrapping was not found: the VTK filters are not wrapped (Debian: python3-vtk9)")
  set(INNERGS_WRAP_PYTHON OFF)
endif()
