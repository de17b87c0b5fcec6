#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Installs the Debian 12 packages that Slalom needs, and only those that are missing.
#   cmake/install-packages.sh         to build and run the programs
#   cmake/install-packages.sh tests   to build and run the tests and benchmarks as well
set -eu

packages="build-essential cmake ninja-build pkg-config
  libmrpt-nav-dev libmrpt-topography-dev libeigen3-dev liboctomap-dev libnlopt-cxx-dev
  coinor-libipopt-dev libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev
  libcli11-dev nlohmann-json3-dev zlib1g-dev libssl-dev"
if [ "${1:-}" = tests ]; then
  packages="$packages libgtest-dev libbenchmark-dev libdynamicedt3d-dev mrpt-common"
fi

missing=""
for package in $packages; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' ||
    missing="$missing $package"
done
[ -z "$missing" ] && exit 0

as_root=""
if [ "$(id -u)" -ne 0 ]; then
  as_root="sudo"
  command -v sudo >/dev/null || { echo "install as root:$missing" >&2; exit 1; }
fi
echo "installing:$missing"
$as_root apt-get update -q
# shellcheck disable=SC2086
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
