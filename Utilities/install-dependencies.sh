#!/bin/sh
# Installs with apt the packages needed for building, testing and the demo; silent and quick if nothing is missing.
# On other systems it lists them and continues; CMake then reports what it cannot find.
set -eu
packages="g++ cmake ninja-build pkg-config libinsighttoolkit5-dev libhwy-dev libcli11-dev nlohmann-json3-dev \
clang-tidy locales libspdlog-dev libgtest-dev libbenchmark-dev libvtk9-dev python3-vtk9 \
qtbase5-dev libvtk9-qt-dev xvfb \
python3-dev python3-numpy python3-venv googletest mricron-data"

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "Not a Debian system: InnerGS needs a C++20 compiler, CMake, Ninja, ITK 5, Highway, CLI11, nlohmann-json," \
    "spdlog, GoogleTest, Google Benchmark and (for the VTK filters) VTK 9.1 or later with its Python modules, and (for the desktop app)" \
    "Qt 5.15 or 6 with VTK's Qt support." >&2
  exit 0
fi

missing=
for package in $packages; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || {
    echo "Please install as root: apt-get install$missing" >&2
    exit 1
  }
  as_root=sudo
fi
echo "Installing$missing"
$as_root apt-get update -q
# shellcheck disable=SC2086  # a list of words
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
