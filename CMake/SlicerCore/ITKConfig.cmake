# The ITK that Slicer's libraries load, for code that needs ITK as well: two ITKs must not be loaded in one process.
set(ITK_INCLUDE_DIRS "${INNERGS_SDK}/third_party/include/ITK-5.4")
set(ITK_LIBRARIES "")
foreach(name ITKCommon itkvnl_algo itkvnl itkv3p_netlib itkvcl itksys)
  list(APPEND ITK_LIBRARIES "${INNERGS_SITE_PACKAGES}/slicer_core/third_party.libs/lib${name}-5.4.so")
endforeach()
set(ITK_VERSION 5.4)
set(ITK_FOUND TRUE)
