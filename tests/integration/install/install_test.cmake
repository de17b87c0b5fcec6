# SPDX-License-Identifier: BSD-3-Clause
# Installs a build tree, and builds and runs a project against that installation alone.
# cmake -DBUILD=... -DWORK=... -DLIBDIR=... -DCXX=... -DFLAGS=... -P install_test.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "${command}: ${code}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(prefix ${WORK}/prefix)
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
foreach(file
    bin/slalom-fly bin/slalom-replay bin/slalom-experiment ${LIBDIR}/slalom-tracker.so
    share/slalom/configs/slalom.ini share/slalom/configs/experiments/e1.ini
    include/slalom/navigator/Navigator.h include/slalom/core/CycleRecord.h)
  if(NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "${file} is not installed")
  endif()
endforeach()
file(GLOB_RECURSE package ${prefix}/${LIBDIR}/cmake/*.cmake)
foreach(file IN LISTS package)
  file(READ ${file} text)
  string(FIND "${text}" "${BUILD}" at)
  if(NOT at EQUAL -1)
    message(FATAL_ERROR "${file} names the build tree")
  endif()
endforeach()

# Installed programs find the installed libraries and plugin.
run(${prefix}/bin/slalom-fly --version)
run(${prefix}/bin/slalom-doctor --config ${prefix}/share/slalom/configs/slalom.ini)

run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/consumer
  -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/consumer)
if(NOT output MATCHES "TrackerNavigatorFactory")
  message(FATAL_ERROR "the plugin was not found: ${output}")
endif()
