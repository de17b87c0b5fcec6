#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# From a fresh Debian 12 to a green test run: installs packages, builds everything, runs all tests.
set -eu
cd "$(dirname "$0")"

cmake/install-packages.sh tests
[ -f build/release/build.ninja ] || cmake --preset release --log-level=WARNING
cmake --build --preset release
ctest --preset release --parallel 2 "$@"
