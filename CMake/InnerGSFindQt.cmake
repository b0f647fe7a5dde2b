# Qt 5.15 or 6 for Widgets, and the part of VTK that draws in its windows. Says what is missing and goes on without. Inside
# a Slicer extension Slicer's own Qt is taken.
if(Slicer_REQUIRED_QT_VERSION)
  string(REGEX MATCH "^[0-9]+" INNERGS_QT "${Slicer_REQUIRED_QT_VERSION}")
  find_package(Qt${INNERGS_QT} REQUIRED COMPONENTS Core Gui Widgets)
else()
  foreach(version 5 6) # in the order of Debian's VTK
    find_package(Qt${version} QUIET COMPONENTS Core Gui Widgets OPTIONAL_COMPONENTS Test)
    if(Qt${version}_FOUND)
      set(INNERGS_QT ${version})
      break()
    endif()
  endforeach()
endif()
find_package(VTK 9.1 QUIET COMPONENTS CommonCore CommonDataModel CommonExecutionModel CommonMath CommonTransforms
  ImagingCore InteractionStyle InteractionWidgets RenderingCore RenderingImage RenderingOpenGL2 RenderingFreeType
  RenderingVolumeOpenGL2 RenderingContext2D RenderingContextOpenGL2 ChartsCore ViewsContext2D FiltersSources FiltersGeneral
  GUISupportQt)
if(NOT Qt${INNERGS_QT}_FOUND OR NOT TARGET VTK::GUISupportQt)
  message(STATUS "Qt 5.15 or 6 and VTK's Qt support were not both found: the panels and the desktop app are not built "
    "(Debian: qtbase5-dev libvtk9-qt-dev)")
  set(INNERGS_BUILD_WIDGETS OFF)
  return()
endif()
message(STATUS "Qt ${Qt${INNERGS_QT}_VERSION}: building the panels and the desktop app")
