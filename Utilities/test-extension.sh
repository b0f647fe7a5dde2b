#!/bin/sh
# Builds the extension against the Slicer build tree in Slicer_DIR (or found by CMake) in the given folder, checks the content of
# its package and runs the module's tests on a virtual display. Without a Slicer, exits with 3 and the reason.
set -eu
build=${1:-build-slicer}
source=$(cd "$(dirname "$0")/.." && pwd)

if [ -z "${Slicer_DIR:-}" ]; then
  mkdir -p "$build"
  printf 'find_package(Slicer QUIET CONFIG)\nif(Slicer_FOUND)\n  message("${Slicer_DIR}")\nendif()\n' >"$build/find.cmake"
  Slicer_DIR=$(cmake -P "$build/find.cmake" 2>&1 | tail -n 1 || true)
fi
if [ ! -f "${Slicer_DIR:-}/SlicerConfig.cmake" ]; then
  echo "No build tree of 3D Slicer was found: set Slicer_DIR to the folder of its SlicerConfig.cmake." >&2
  exit 3
fi

echo "Building the extension with the Slicer in $Slicer_DIR"
cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSlicer_DIR="$Slicer_DIR" --log-level=WARNING
cmake --build "$build"
display=
if command -v xvfb-run >/dev/null; then
  display='xvfb-run -a -s "-screen 0 1600x1200x24"'
fi
export Slicer_DIR
"$source/Utilities/check-extension-package.sh" "$build"
cd "$build"
eval "$display" env LIBGL_ALWAYS_SOFTWARE=1 ctest --output-on-failure --no-tests=error
