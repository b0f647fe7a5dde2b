# Highway and nlohmann-json for an extension of 3D Slicer: where they are installed, those; else, as on Slicer's build
# machines, these revisions from their public repositories, built with the extension and linked into it.
include(FetchContent)
set(INNERGS_FETCHED "")
find_package(hwy CONFIG QUIET)
if(NOT TARGET hwy::hwy)
  find_package(PkgConfig QUIET)
  if(PKG_CONFIG_FOUND)
    pkg_check_modules(HWY QUIET IMPORTED_TARGET libhwy)
  endif()
  if(NOT HWY_FOUND)
    FetchContent_Declare(highway GIT_REPOSITORY https://github.com/google/highway.git
      GIT_TAG 457c891775a7397bdb0376bb1031e6e027af1c48) # 1.2.0
    list(APPEND INNERGS_FETCHED highway)
  endif()
endif()
find_package(nlohmann_json 3.9 QUIET)
if(NOT nlohmann_json_FOUND)
  FetchContent_Declare(nlohmann_json GIT_REPOSITORY https://github.com/nlohmann/json.git
    GIT_TAG 9cca280a4d0ccf0c08f47a99aa71d1b0e52f8d03) # 3.11.3
  list(APPEND INNERGS_FETCHED nlohmann_json)
endif()

function(innergs_fetch) # the projects' options and the static libraries stay in here
  set(CMAKE_POLICY_DEFAULT_CMP0077 NEW)
  set(BUILD_SHARED_LIBS OFF)
  set(BUILD_TESTING OFF)
  set(HWY_FORCE_STATIC_LIBS ON)
  foreach(part CONTRIB EXAMPLES INSTALL TESTS)
    set(HWY_ENABLE_${part} OFF CACHE BOOL "" FORCE)
  endforeach()
  set(JSON_BuildTests OFF)
  set(JSON_Install OFF)
  message(STATUS "Fetching ${INNERGS_FETCHED}")
  FetchContent_MakeAvailable(${INNERGS_FETCHED})
endfunction()
if(INNERGS_FETCHED)
  innergs_fetch()
  if(TARGET hwy AND NOT TARGET hwy::hwy)
    add_library(hwy::hwy ALIAS hwy)
  endif()
endif()
