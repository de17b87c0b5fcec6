#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# From a fresh Debian 12 to pictures: installs packages, builds, replays the shipped flight, says where the report is.
set -eu
cd "$(dirname "$0")"

cmake/install-packages.sh
[ -f build/demo/build.ninja ] || cmake -S . -B build/demo -G Ninja --log-level=WARNING \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O2 -DNDEBUG" \
  -DSLALOM_BUILD_TESTS=OFF -DSLALOM_BUILD_BENCHMARKS=OFF
cmake --build build/demo --target slalom-replay slalom_tracker

flight=datasets/forest_slalom
code=0
build/demo/bin/slalom-replay --config "$flight/replay.ini" --rawlog "$flight/flight.rawlog" \
  --out slalom-report --overwrite "$@" || code=$?
echo "The report is in $(pwd)/slalom-report; the first page to look at is slalom-report/overview.png"
exit $code
