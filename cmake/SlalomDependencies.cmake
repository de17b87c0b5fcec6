# SPDX-License-Identifier: BSD-3-Clause
# Every third-party package, found once. All of them are Debian 12 packages.

find_package(Threads REQUIRED)
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(NLopt REQUIRED)
find_package(nlohmann_json 3 REQUIRED)
find_package(CLI11 2 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
foreach(module nav obs maps topography)
  find_package(mrpt-${module} 2.5 REQUIRED)
endforeach()

# Ipopt has no CMake package; its pkg-config file also brings the -D flags that its headers need.
find_package(PkgConfig REQUIRED)
pkg_check_modules(IPOPT REQUIRED IMPORTED_TARGET GLOBAL ipopt)

# OctoMap exports variables only.
find_package(octomap REQUIRED)
add_library(slalom_octomap INTERFACE)
target_include_directories(slalom_octomap SYSTEM INTERFACE ${OCTOMAP_INCLUDE_DIRS})
target_link_libraries(slalom_octomap INTERFACE ${OCTOMAP_LIBRARIES})
target_compile_definitions(slalom_octomap INTERFACE OCTOMAP_NODEBUGOUT)  # no chatter on stderr

# OpenCV's CMake package lives in the 1 GB libopencv-dev; the slim -dev packages have headers and libraries only.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(slalom_opencv INTERFACE)
target_include_directories(slalom_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
foreach(part core imgproc imgcodecs)
  find_library(OPENCV_${part}_LIBRARY opencv_${part} REQUIRED)
  target_link_libraries(slalom_opencv INTERFACE ${OPENCV_${part}_LIBRARY})
endforeach()

if(SLALOM_BUILD_TESTS)
  find_package(GTest REQUIRED)
  include(GoogleTest)
  if(SLALOM_BUILD_BENCHMARKS)
    find_package(benchmark REQUIRED)
  endif()
endif()
