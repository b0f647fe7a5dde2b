# Builds Logic/MRML against the libraries that Utilities/fetch-slicer-core.sh fetched to INNERGS_SLICER_CORE, instead of a Slicer.
# Include it before any target: find_package(VTK) and find_package(ITK) then find the libraries that Slicer's own were built with,
# and everything is compiled with their C++ ABI (that of manylinux).
get_filename_component(INNERGS_SLICER_CORE "${INNERGS_SLICER_CORE}" ABSOLUTE BASE_DIR "${CMAKE_BINARY_DIR}")
if(NOT EXISTS "${INNERGS_SLICER_CORE}/complete")
  message(FATAL_ERROR "Run Utilities/fetch-slicer-core.sh ${INNERGS_SLICER_CORE} first.")
endif()
add_compile_definitions(_GLIBCXX_USE_CXX11_ABI=0)
set(VTK_DIR "${CMAKE_CURRENT_LIST_DIR}" CACHE PATH "" FORCE)
set(ITK_DIR "${CMAKE_CURRENT_LIST_DIR}" CACHE PATH "" FORCE)
set(Python3_EXECUTABLE "${INNERGS_SLICER_CORE}/venv/bin/python" CACHE FILEPATH "" FORCE)
find_package(Python3 REQUIRED COMPONENTS Interpreter Development)

execute_process(COMMAND "${Python3_EXECUTABLE}" -c "import sysconfig; print(sysconfig.get_path('purelib'))"
  OUTPUT_VARIABLE INNERGS_SITE_PACKAGES OUTPUT_STRIP_TRAILING_WHITESPACE)
set(INNERGS_SDK "${INNERGS_SITE_PACKAGES}/slicer_core_sdk/content")
set(INNERGS_SLICER_LIBRARIES
  "${INNERGS_SITE_PACKAGES}/slicer_core"
  "${INNERGS_SITE_PACKAGES}/vtkmodules"
  "${INNERGS_SITE_PACKAGES}/slicer_core/third_party.libs")
set(CMAKE_BUILD_RPATH ${INNERGS_SLICER_LIBRARIES})
# The libraries find each other and libpython through these folders.
foreach(folder ${INNERGS_SLICER_LIBRARIES})
  add_link_options("-Wl,-rpath-link,${folder}")
endforeach()
