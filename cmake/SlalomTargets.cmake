# SPDX-License-Identifier: BSD-3-Clause
# How every target of Slalom is made: layered libraries, programs, tests and benchmarks.

include(GNUInstallDirs)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_EXTENSIONS OFF)

find_program(SLALOM_CCACHE ccache)
if(SLALOM_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SLALOM_CCACHE})
endif()

add_library(slalom_warnings INTERFACE)
target_compile_options(slalom_warnings INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion)

# The house: a library may link only libraries of a lower layer (docs/architecture.md).
set(SLALOM_LAYER_core 0)
foreach(library spline optim geometry mapping estimation tracking safety mrpt_io)
  set(SLALOM_LAYER_${library} 1)
endforeach()
set(SLALOM_LAYER_search 2)
foreach(library global_planner local_planner simulation report)
  set(SLALOM_LAYER_${library} 3)
endforeach()
set(SLALOM_LAYER_engine 4)
set(SLALOM_LAYER_navigator 5)

# slalom_library(<name> SOURCES ... HEADERS ... [USES slalom libs ...] [PUBLIC ...] [PRIVATE ...] [SHARED])
# Headers are relative to include/slalom/<name>/, sources to src/. A library without sources is header-only.
function(slalom_library name)
  cmake_parse_arguments(PARSE_ARGV 1 LIB "SHARED" "" "SOURCES;HEADERS;USES;PUBLIC;PRIVATE")
  if(NOT DEFINED SLALOM_LAYER_${name})
    message(FATAL_ERROR "slalom_library(${name}): give the library a layer in SlalomTargets.cmake")
  endif()
  list(TRANSFORM LIB_SOURCES PREPEND src/)
  list(TRANSFORM LIB_HEADERS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/include/slalom/${name}/)
  set(scope PUBLIC)
  if(LIB_SHARED)
    add_library(slalom_${name} SHARED ${LIB_SOURCES})
  elseif(LIB_SOURCES)
    add_library(slalom_${name} STATIC ${LIB_SOURCES})
  else()
    add_library(slalom_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(slalom::${name} ALIAS slalom_${name})
  target_compile_features(slalom_${name} ${scope} cxx_std_20)
  target_sources(slalom_${name} ${scope} FILE_SET HEADERS
    BASE_DIRS ${CMAKE_CURRENT_SOURCE_DIR}/include FILES ${LIB_HEADERS})
  foreach(used IN LISTS LIB_USES)
    if(NOT SLALOM_LAYER_${used} LESS SLALOM_LAYER_${name})
      message(FATAL_ERROR "slalom::${name} (layer ${SLALOM_LAYER_${name}}) may not use "
        "slalom::${used} (layer ${SLALOM_LAYER_${used}}): arrows point down only")
    endif()
    target_link_libraries(slalom_${name} ${scope} slalom::${used})
  endforeach()
  target_link_libraries(slalom_${name} ${scope} ${LIB_PUBLIC})
  if(NOT scope STREQUAL INTERFACE)
    target_link_libraries(slalom_${name} PRIVATE
      ${LIB_PRIVATE} $<BUILD_INTERFACE:slalom_warnings>)
  endif()
  set_target_properties(slalom_${name} PROPERTIES EXPORT_NAME ${name})
endfunction()

# slalom_test(<library> SOURCES ... [USES libs...] [LIBRARIES ...] [LABELS ...])
# One test program test_<library>; its sources see that library and tests/support only.
function(slalom_test name)
  cmake_parse_arguments(PARSE_ARGV 1 TEST "" "TIMEOUT" "SOURCES;LIBRARIES;LABELS")
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 300)
  endif()
  add_executable(test_${name} ${TEST_SOURCES})
  target_link_libraries(test_${name} PRIVATE
    ${TEST_LIBRARIES} slalom_test_support GTest::gtest_main slalom_warnings)
  gtest_discover_tests(test_${name} DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT ${TEST_TIMEOUT} LABELS "${TEST_LABELS}")
endfunction()

# slalom_benchmark(<name> SOURCES ... LIBRARIES ...): a google-benchmark program bench_<name>.
function(slalom_benchmark name)
  cmake_parse_arguments(PARSE_ARGV 1 BENCH "" "" "SOURCES;LIBRARIES")
  add_executable(bench_${name} ${BENCH_SOURCES})
  target_link_libraries(bench_${name} PRIVATE
    ${BENCH_LIBRARIES} slalom_test_support benchmark::benchmark_main slalom_warnings)
endfunction()

# slalom_program(<name> SOURCES ... LIBRARIES ...)
function(slalom_program name)
  cmake_parse_arguments(PARSE_ARGV 1 PROGRAM "" "" "SOURCES;LIBRARIES")
  add_executable(${name} ${PROGRAM_SOURCES})
  target_link_libraries(${name} PRIVATE ${PROGRAM_LIBRARIES} slalom_warnings)
  set_target_properties(${name} PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
