#!/bin/sh
# Installs OpenVINO from PyPI (60 MB, seconds) into a Python environment of its own, for the tests that run networks. Without
# Python or the package index says so and succeeds: those tests are then skipped.
# Usage: fetch-openvino.sh FOLDER
set -u
folder=$1
[ -z "$(find "$folder" -name 'libopenvino_c*' 2>/dev/null | head -n 1)" ] || exit 0
if python3 -m venv "$folder" && "$folder/bin/pip" install --quiet --disable-pip-version-check --no-deps --timeout 20 \
    --retries 1 "openvino>=2025.4"; then
  exit 0
fi >&2
rm -rf "$folder"
echo "OpenVINO could not be installed: tests that run networks are skipped." >&2
