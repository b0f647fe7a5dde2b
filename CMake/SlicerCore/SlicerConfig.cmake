# Slicer's MRML and logic libraries as imported targets, with the names that they have in a Slicer build.
foreach(name MRMLCore MRMLLogic vtkSlicerBaseLogic vtkSlicerMarkupsModuleMRML vtkSlicerSegmentationsModuleMRML
    vtkSlicerSegmentationsModuleLogic vtkSegmentationCore vtkSlicerSubjectHierarchyModuleLogic
    vtkSlicerVolumesModuleLogic vtkSlicerColorsModuleLogic
    vtkSlicerSequencesModuleMRML vtkSlicerSequencesModuleLogic)
  add_library(${name} SHARED IMPORTED)
  set_target_properties(${name} PROPERTIES
    IMPORTED_LOCATION "${INNERGS_SITE_PACKAGES}/slicer_core/lib${name}.so"
    INTERFACE_INCLUDE_DIRECTORIES "${INNERGS_SLICER_CORE}/include;${INNERGS_SDK}/include;\
${INNERGS_SDK}/third_party/include/vtkAddon;${INNERGS_SDK}/third_party/include/ITK-5.4"
    INTERFACE_LINK_LIBRARIES "${INNERGS_SITE_PACKAGES}/slicer_core/third_party.libs/libvtkAddon.so"
    INTERFACE_vtk_module_hierarchy "${INNERGS_SDK}/hierarchy/${name}-hierarchy.txt")
endforeach()
