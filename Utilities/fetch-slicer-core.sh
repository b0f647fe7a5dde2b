#!/usr/bin/env bash
# Fetches what building and testing Logic/MRML needs in place of a Slicer: Slicer's own MRML and logic libraries and headers
# (slicer-core and slicer-core-sdk from PyPI), the VTK wheel that they need and, since no wheel contains them, VTK's headers and
# wrapping tools from the Debian release with exactly that version.
# Usage: fetch-slicer-core.sh FOLDER     Quick if FOLDER is complete. Changes nothing outside FOLDER.
# Exit status 3: unavailable here; the last line on stderr says why.
set -euo pipefail
slicer=5.13.31053.0
suite=forky # Debian release with VTK's headers
python=${PYTHON:-/usr/bin/python3}
limit=${INNERGS_FETCH_LIMIT:-900} # seconds per download, so that a dead network ends with a message

unavailable() {
  echo "Slicer's libraries cannot be had: $*" >&2
  exit 3
}
[ $# -eq 1 ] || { echo "usage: $0 FOLDER" >&2; exit 2; }
mkdir -p "$1"
folder=$(cd "$1" && pwd)
cd "$folder"
[ "$(cat complete 2>/dev/null || true)" = "$slicer" ] && exit 0
rm -f complete

[ "$(uname -s)-$(uname -m)" = Linux-x86_64 ] || unavailable "there are wheels with an SDK for Linux x86-64 alone."
command -v apt-get dpkg-deb >/dev/null || unavailable "VTK's headers come from Debian packages, and this system has no apt."
"$python" -c 'import ensurepip, sysconfig, os; assert os.path.exists(sysconfig.get_path("include") + "/Python.h")' \
  2>/dev/null || unavailable "$python has no venv module or no headers (Debian: python3-venv, python3-dev)."

# From PyPI.
[ -x venv/bin/python ] || "$python" -m venv venv >&2 || unavailable "no Python environment could be made."
timeout "$limit" venv/bin/python -m pip install --quiet --disable-pip-version-check --timeout 30 --retries 2 "slicer-core==$slicer" \
  "slicer-core-sdk==$slicer" numpy >&2 ||
  unavailable "pip got no slicer-core $slicer with its SDK for $($python --version) within $limit s."
vtk=$(venv/bin/python -c 'from importlib.metadata import version; print(version("vtk"))')

# From Debian, with a private apt: its own sources, lists and cache, and this machine's mirror.
mirror=$(apt-get indextargets --format '$(LABEL) $(REPO_URI)' 'Created-By: Packages' 2>/dev/null |
  sed -n 's/^Debian //p' | head -n 1)
[ -n "$mirror" ] || mirror=$(cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null |
  grep -v '^#' | grep -o 'https\?://[^ ]*/debian/\?\( \|$\)' | head -n 1)
[ -n "$mirror" ] || unavailable "no Debian mirror is among the apt sources of this machine."
mkdir -p apt/lists/partial apt/cache/archives/partial apt/parts debs
: >apt/status
echo "deb $mirror $suite main" >apt/sources.list
cat >apt/apt.conf <<EOF
Dir::State "$folder/apt"; Dir::State::lists "$folder/apt/lists"; Dir::State::status "$folder/apt/status";
Dir::Cache "$folder/apt/cache"; Dir::Etc::sourcelist "$folder/apt/sources.list"; Dir::Etc::sourceparts "$folder/apt/parts";
Dir::Etc::preferences "-"; Dir::Etc::preferencesparts "$folder/apt/parts";
APT::Architecture "amd64"; APT::Architectures "amd64"; APT::Sandbox::User "root"; Acquire::Languages "none";
Acquire::Retries "2"; Acquire::http::Timeout "30"; Acquire::https::Timeout "30";
EOF
export APT_CONFIG="$folder/apt/apt.conf"
timeout "$limit" apt-get update -qq >&2 || unavailable "the index of Debian $suite could not be read within $limit s."
(cd debs && rm -f ./*.deb && timeout "$limit" apt-get download -qq libvtk9-dev libvtk9.6 vtk9 python3-vtk9 libc6 >&2) ||
  unavailable "Debian $suite no longer has the packages of VTK $vtk, or they did not come within $limit s."
rm -rf tools include
for package in libvtk9-dev vtk9 python3-vtk9 libc6; do
  dpkg-deb --fsys-tarfile debs/${package}_*.deb | tar -x -C apt --one-top-level=root --exclude='*/doc/*' --exclude='*.pyi' \
    --exclude='*/dist-packages/*'
done
dpkg-deb --fsys-tarfile debs/libvtk9.6_*.deb | tar -x -C apt --one-top-level=root --wildcards '*/hierarchy/*'
mv apt/root/usr/include/vtk-* include
version=$(sed -n 's/^#define VTK_VERSION "\(.*\)"/\1/p' include/vtkVersionMacros.h)
[ "$version" = "$vtk" ] || unavailable "the wheel is VTK $vtk, Debian $suite has the headers of VTK $version."

# The wrapping tools may need a newer C library than this machine's, so they run through their own loader, with the wheel's
# library of the same version.
lib=apt/root/usr/lib/x86_64-linux-gnu
mkdir -p tools/lib tools/hierarchy
cp $lib/ld-linux-x86-64.so.2 $lib/libc.so.6 tools/lib
cp $lib/vtk-*/hierarchy/*/*.txt $lib/vtk-*/hierarchy/*.txt tools/hierarchy 2>/dev/null || true
wheel=$(venv/bin/python -c 'import vtkmodules; print(vtkmodules.__path__[0])')
ln -sf "$wheel/libvtkWrappingTools.so" "tools/lib/libvtkWrappingTools-${vtk%.*}.so.1"
for tool in WrapHierarchy WrapPython WrapPythonInit; do
  cp apt/root/usr/bin/vtk$tool-* "tools/lib/vtk$tool"
  cat >"tools/vtk$tool" <<EOF
#!/bin/sh
exec "$folder/tools/lib/ld-linux-x86-64.so.2" --library-path "$folder/tools/lib" "$folder/tools/lib/vtk$tool" "\$@"
EOF
  chmod +x "tools/vtk$tool"
done
tools/vtkWrapPython --version >/dev/null 2>&1 || unavailable "the wrapping tools of Debian $suite do not run here."
# Debian builds VTK with TBB, the wheel is built without.
sed -e 's/^#define VTK_SMP_TBB$/#define VTK_SMP_STDThread/' -e 's/\(VTK_SMP_BACKEND\) "TBB"/\1 "STDThread"/' \
  -e 's/\(VTK_SMP_ENABLE_TBB\) 1/\1 0/' -e 's/\(VTK_SMP_DEFAULT_IMPLEMENTATION_TBB\) 1/\1 0/' \
  -e 's/\(VTK_SMP_DEFAULT_IMPLEMENTATION_STDTHREAD\) 0/\1 1/' -i include/vtkSMP.h
rm -rf apt debs
echo "$slicer" >complete
