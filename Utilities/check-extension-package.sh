#!/bin/sh
# Installs the extension built in the given folder to a temporary one, as for its package, and checks that no file is missing or
# superfluous and that the Slicer in Slicer_DIR runs it from there.
set -eu
: "${Slicer_DIR:?the folder of SlicerConfig.cmake}"
build=$(cd "$1" && pwd)
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
fail() {
  echo "The extension's package: $1" >&2
  exit 1
}

DESTDIR="$stage" cmake --install "$build" --prefix / >"$stage.log" || { cat "$stage.log" >&2; exit 1; }
rm -f "$stage.log"
(cd "$stage" && find . -type f) | sed 's|^\./||; s|Slicer-[0-9.]*|Slicer|; s|\.cpython-[0-9]*||' | LC_ALL=C sort >"$stage/found"
{
  modules=lib/Slicer/qt-loadable-modules
  for library in libqSlicerInnerGSModule libvtkInnerGS libvtkSlicerInnerGSModuleLogic libvtkSlicerInnerGSModuleMRML; do
    echo "$modules/$library.so"
  done
  for library in vtkInnerGS vtkSlicerInnerGSModuleLogic vtkSlicerInnerGSModuleMRML; do
    echo "$modules/${library}Python.so"
  done
  for script in __init__ _jobs _moving _parameters _queries _scene _segments; do
    echo "$modules/Python/innergs/$script.py"
    echo "$modules/Python/innergs/__pycache__/$script.pyc"
  done
  echo share/Slicer/InnerGS/LICENSE
} | LC_ALL=C sort >"$stage/wanted"
sed -i '/^found$/d' "$stage/found" # itself
difference=$(diff "$stage/wanted" "$stage/found" | grep '^[<>]' || true)
# Slicer's launcher adds the extension's description, fetched libraries their licences.
difference=$(printf '%s' "$difference" | grep -v '^> share/Slicer/\(InnerGS\.\(s4ext\|json\)\|InnerGS/LICENSE\.[a-z_]*\)$' || true)
[ -z "$difference" ] || fail "< is missing, > should not be there:
$difference"

for library in $(find "$stage" -name '*.so'); do
  name=$(basename "$library")
  if readelf -d "$library" | grep -E 'R(UN)?PATH' | grep -q '[:[]/'; then
    fail "$name looks for libraries in folders of this machine: $(readelf -d "$library" | grep -E 'R(UN)?PATH')"
  fi
  if readelf -d "$library" | grep -q 'NEEDED.*libhwy'; then
    echo "Note: $name needs this machine's libhwy; configure with -DINNERGS_FETCH_DEPENDENCIES=ON for a package to pass on." >&2
  fi
done

# Runs it from the installed folder, not the build folder, with the paths that Slicer's extension manager passes to its launcher.
slicer="$Slicer_DIR/Slicer"
[ -x "$slicer" ] || { echo "Not run from the package: there is no $slicer." >&2; exit 0; }
modules=$(find "$stage" -type d -name qt-loadable-modules | head -n 1)
cat >"$stage/try.py" <<'PYTHON'
import sys, traceback
try:
    import innergs, slicer
    from vtkInnerGSPython import vtkInnerGSModel
    assert innergs.logic() == slicer.modules.innergs.logic() and vtkInnerGSModel().IsEmpty()
    assert slicer.modules.innergs.path.startswith(sys.argv[1]), slicer.modules.innergs.path
    open(sys.argv[1] + "/ran", "w").close()
except Exception:
    traceback.print_exc()
finally:
    slicer.util.exit(0)
PYTHON
display=
if command -v xvfb-run >/dev/null; then
  display='xvfb-run -a'
fi
LD_LIBRARY_PATH="$modules:${LD_LIBRARY_PATH:-}" PYTHONPATH="$modules:$modules/Python:${PYTHONPATH:-}" \
  LIBGL_ALWAYS_SOFTWARE=1 timeout 120 $display "$slicer" --no-splash --disable-settings --no-main-window \
  --additional-module-paths "$modules" --python-script "$stage/try.py" "$stage" >"$stage/log" 2>&1 || true
[ -e "$stage/ran" ] || { cat "$stage/log" >&2; fail "Slicer does not run the module from it."; }
echo "The extension's package is complete and runs: $(grep -c . "$stage/found") files."
