# Qt 5.15 or 6 for Widgets, and the part of VTK that draws in its windows. VTK's part was built with one major version of Qt, and
# a program cannot load both, so that version is used. If something is missing, says so and continues without; a requested version
# that does not match is an error. Inside a Slicer extension, uses Slicer's own Qt.
set(INNERGS_QT_VERSION "${QT_DEFAULT_MAJOR_VERSION}" CACHE STRING
  "Qt's major version for the panels and the app, 5 or 6; empty: the one of VTK's Qt support")
set_property(CACHE INNERGS_QT_VERSION PROPERTY STRINGS "" 5 6)

find_package(VTK 9.1 QUIET COMPONENTS CommonCore CommonDataModel CommonExecutionModel CommonMath CommonTransforms
  ImagingCore InteractionStyle InteractionWidgets RenderingCore RenderingImage RenderingOpenGL2 RenderingFreeType
  RenderingVolumeOpenGL2 FiltersSources FiltersGeneral
  GUISupportQt)
set(INNERGS_QT "")
if(TARGET VTK::GUISupportQt)
  get_target_property(links VTK::GUISupportQt INTERFACE_LINK_LIBRARIES)
  if(links MATCHES "Qt([56])::")
    set(INNERGS_QT ${CMAKE_MATCH_1})
  else()
    set(INNERGS_QT "${VTK_QT_VERSION}")
  endif()
endif()

set(asked "${INNERGS_QT_VERSION}")
set(asked_by "INNERGS_QT_VERSION is")
if(Slicer_REQUIRED_QT_VERSION)
  string(REGEX MATCH "^[0-9]+" asked "${Slicer_REQUIRED_QT_VERSION}")
  set(asked_by "this Slicer's Qt version is")
endif()
if(asked AND INNERGS_QT AND NOT asked EQUAL INNERGS_QT)
  message(FATAL_ERROR "${asked_by} ${asked}, but the Qt support of the VTK in ${VTK_DIR} was built with Qt ${INNERGS_QT}. "
    "Set VTK_DIR to a VTK that was built with VTK_QT_VERSION=${asked}, or use Qt ${INNERGS_QT}.")
endif()

if(NOT INNERGS_QT)
  message(STATUS "VTK's Qt support was not found: the panels and the desktop app are not built (Debian: libvtk9-qt-dev)")
  set(INNERGS_BUILD_WIDGETS OFF)
  return()
endif()
set(least_5 5.15)
set(least_6 6.2)
find_package(Qt${INNERGS_QT} ${least_${INNERGS_QT}} QUIET COMPONENTS Core Gui Widgets OPTIONAL_COMPONENTS Test)
if(NOT Qt${INNERGS_QT}_FOUND)
  set(packages_5 qtbase5-dev)
  set(packages_6 "qt6-base-dev libqt6opengl6-dev")
  message(STATUS "Qt ${least_${INNERGS_QT}} or later was not found, and VTK's Qt support was built with Qt ${INNERGS_QT}: the panels "
    "and the desktop app are not built (Debian: ${packages_${INNERGS_QT}}; or set Qt${INNERGS_QT}_DIR)")
  set(INNERGS_BUILD_WIDGETS OFF)
  return()
endif()
message(STATUS "Qt ${Qt${INNERGS_QT}_VERSION}: building the panels and the desktop app")
