# A 3D Slicer extension: the layers that its module needs, with Slicer's own VTK, ITK and Qt; without the command line, the
# desktop app and nvcc.
set(INNERGS_BUILD_IO OFF) # model files only; Slicer reads volumes
set(INNERGS_BUILD_VTK ON)
set(INNERGS_BUILD_WIDGETS ON)
set(Slicer_VTK_WRAP_HIERARCHY_DIR "${CMAKE_BINARY_DIR}") # keeps it out of Slicer's own build tree
include(CMake/InnerGSDependencies.cmake)
add_subdirectory(Logic/Core)
add_subdirectory(Logic/Onnx)
add_subdirectory(Logic/Text)
add_subdirectory(Logic/IO)
add_subdirectory(Logic/Evaluation)
find_package(VTK 9.1 REQUIRED COMPONENTS CommonCore CommonDataModel CommonExecutionModel CommonMath CommonTransforms)
add_subdirectory(Logic/VTK)
add_subdirectory(Logic/MRML)
include(CMake/InnerGSFindQt.cmake)
if(NOT INNERGS_BUILD_WIDGETS)
  message(FATAL_ERROR "Slicer's VTK has no Qt support.")
endif()
add_subdirectory(Widgets)
add_subdirectory(InnerGSModule)
