#!/bin/sh
# Updates the screenshots of the desktop app (Docs/screenshots/app-*.png) from the demo's brain, on a virtual display.
# Usage: screenshots.sh PROGRAM FOLDER   (PROGRAM: build/bin/innergs_screenshots)
# INNERGS_NAMED_SCAN, INNERGS_NAMED_MODEL: a scan and a model of it that has learned its liver, for app-find.png.
set -eu
program=${1:?usage: screenshots.sh PROGRAM FOLDER}
out=${2:?usage: screenshots.sh PROGRAM FOLDER}
mkdir -p "$out"
settings=$(mktemp -d)
trap 'rm -rf "$settings"' EXIT
export INNERGS_SETTINGS="$settings/settings.ini" XDG_RUNTIME_DIR="$settings" LIBGL_ALWAYS_SOFTWARE=1 QT_LOGGING_RULES="qt.qpa.*=false"
xvfb-run -a -s "-screen 0 1600x1200x24" "$program" "$out" all
rm -f "$INNERGS_SETTINGS"
if [ -n "${INNERGS_NAMED_SCAN:-}" ] && [ -n "${INNERGS_NAMED_MODEL:-}" ]; then
  xvfb-run -a -s "-screen 0 1600x1200x24" "$program" "$out" find liver "$INNERGS_NAMED_SCAN" "$INNERGS_NAMED_MODEL"
  rm -f "$INNERGS_SETTINGS"
fi
QT_SCALE_FACTOR=1.5 xvfb-run -a -s "-screen 0 2400x1600x24" "$program" "$out" scaled
