#!/bin/sh
# Reconstructs a real head, Colin27, at 1 mm from three orthogonal scans with 5 mm slices.
# Usage: demo.sh INNERGS FOLDER
set -eu
innergs=${1:?usage: demo.sh INNERGS FOLDER}
out=${2:?usage: demo.sh INNERGS FOLDER}
head=/usr/share/mricron/templates/ch2.nii.gz # Debian package mricron-data
[ -f "$head" ] || {
  echo "The demo needs $head (Debian package mricron-data)." >&2
  exit 1
}
mkdir -p "$out"

echo "Reconstructing the Colin27 head from three orthogonal scans with 5 mm slices"
"$innergs" evaluate "$head" --orthogonal 3 --thickness 5 --save-volume "$out/colin27.nii.gz" \
  --save-model "$out/colin27.innergs" --picture "$out/colin27.png" --json "$out/colin27.json"
"$innergs" slice "$out/colin27.innergs" --quiet --normal 1,1,1 --spacing 0.5 -o "$out/colin27-oblique.png"

cat <<END

Look at
  $out/colin27.png          three planes: a scan, the result, the truth, the errors
  $out/colin27-oblique.png  a plane at an angle that nobody scanned, at 0.5 mm
  $out/colin27.nii.gz       the volume, for any viewer
  $out/colin27.innergs      the continuous model: innergs slice, innergs resample
END
