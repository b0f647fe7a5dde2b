#!/bin/sh
# Updates the screenshots of the desktop app (Docs/screenshots/app-*.png) from the demo's brain, on a virtual display.
# Usage: screenshots.sh PROGRAM FOLDER   (PROGRAM: build/bin/innergs_screenshots)
set -eu
program=${1:?usage: screenshots.sh PROGRAM FOLDER}
out=${2:?usage: screenshots.sh PROGRAM FOLDER}
mkdir -p "$out"
settings=$(mktemp -d)
trap 'rm -rf "$settings"' EXIT
export INNERGS_SETTINGS="$settings/settings.ini" XDG_RUNTIME_DIR="$settings" LIBGL_ALWAYS_SOFTWARE=1 QT_LOGGING_RULES="qt.qpa.*=false"
xvfb-run -a -s "-screen 0 1600x1200x24" "$program" "$out" all
rm -f "$INNERGS_SETTINGS"
QT_SCALE_FACTOR=1.5 xvfb-run -a -s "-screen 0 2400x1600x24" "$program" "$out" scaled
