# The VTK wheel's libraries with headers of the same version, as imported targets with VTK's own names.
if(NOT EXISTS "${INNERGS_SITE_PACKAGES}/vtk-${VTK_VERSION}.dist-info")
  message(FATAL_ERROR "The headers are VTK ${VTK_VERSION}, the VTK wheel is not: fetch both again.")
endif()

file(GLOB libraries "${INNERGS_SITE_PACKAGES}/vtkmodules/libvtk*.so")
foreach(library ${libraries})
  get_filename_component(name "${library}" NAME_WE)
  string(REPLACE "libvtk" "" name "${name}")
  if(name MATCHES "^WrappingPythonCore")
    set(name WrappingPythonCore)
  endif()
  if(NOT TARGET VTK::${name})
    add_library(VTK::${name} SHARED IMPORTED)
    set_target_properties(VTK::${name} PROPERTIES
      IMPORTED_LOCATION "${library}"
      INTERFACE_INCLUDE_DIRECTORIES "${INNERGS_SLICER_CORE}/include"
      INTERFACE_LINK_LIBRARIES "${INNERGS_SITE_PACKAGES}/vtkmodules/libvtksys.so"
      INTERFACE_vtk_module_hierarchy "${INNERGS_SLICER_CORE}/tools/hierarchy/vtk${name}-hierarchy.txt")
  endif()
endforeach()
if(NOT TARGET VTK::Python)
  add_library(VTK::Python INTERFACE IMPORTED)
  set_target_properties(VTK::Python PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${Python3_INCLUDE_DIRS}")
  foreach(tool WrapHierarchy WrapPython WrapPythonInit)
    add_executable(VTK::${tool} IMPORTED)
    set_target_properties(VTK::${tool} PROPERTIES IMPORTED_LOCATION "${INNERGS_SLICER_CORE}/tools/vtk${tool}")
  endforeach()
endif()
set(VTK_FOUND TRUE)
