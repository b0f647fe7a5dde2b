#!/usr/bin/env bash
# Collects in one folder everything to test and measure the CUDA backend on a machine with a GPU: the plugin, its tests, the
# benchmark, their libraries, a volume and a script. That machine needs only a driver and the C library.
# Usage: Utilities/cuda-bundle.sh BUILD FOLDER [VOLUME.nii|VOLUME.nii.gz]
set -euo pipefail
build=${1:?usage: cuda-bundle.sh BUILD FOLDER [VOLUME]} out=${2:?usage: cuda-bundle.sh BUILD FOLDER [VOLUME]} volume=${3:-}
rm -rf "$out"
mkdir -p "$out/lib" "$out/plugin" "$out/host-plugin"
for program in innergs_cuda_tests innergs_cuda_kernel_tests innergs_cuda_job_tests innergs_cuda_benchmark; do
  cp "$build/bin/$program" "$out/"
  # All except the C library's parts, which must be the machine's own.
  ldd "$build/bin/$program" | awk '/=> \// { print $3 }' |
    grep -Ev '/(libc|libm|libdl|librt|libpthread|ld-linux[^/]*)\.so' | xargs -r -I{} cp -Lu {} "$out/lib/"
done
cp "$build/lib/libinnergs_cuda.so" "$out/plugin/"
cp "$build/Testing/plugins/host/libinnergs_cuda.so" "$out/host-plugin/"
case $volume in
  '') echo "No volume given (INNERGS_BRAINWEB): the benchmark will measure on a synthetic one." >&2 ;;
  *.gz) gunzip -c "$volume" > "$out/brainweb.nii" ;;
  *) cp "$volume" "$out/brainweb.nii" ;;
esac
cat > "$out/run.sh" <<'RUN'
#!/usr/bin/env bash
# run.sh test|bench|sanitize|trial [FOLDER]: logs and figures go to FOLDER (default: results beside this script).
cd "$(dirname "$0")"
what=${1:-test} results=${2:-results}
mkdir -p "$results"
export LD_LIBRARY_PATH=$PWD/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} INNERGS_PLUGIN_PATH=$PWD/plugin
volume=()
[ ! -s brainweb.nii ] || volume=(--volume brainweb.nii)
failed=0
logged() { # NAME SECONDS COMMAND...
  local name=$1 limit=$2 code=0
  shift 2
  echo "==== $name"
  timeout "$limit" "$@" > "$results/$name.log" 2>&1 || code=$?
  tail -n 60 "$results/$name.log"
  [ $code = 0 ] || { echo "**** $name ended with $code"; failed=1; }
}
nvidia-smi --query-gpu=name,driver_version,memory.total,clocks.max.sm,clocks.max.mem,power.limit --format=csv \
  > "$results/device.csv" 2>&1 || echo "nvidia-smi did not run" >> "$results/device.csv"
cat "$results/device.csv"
case $what in
  test)
    logged math-tests 60 ./innergs_cuda_tests
    logged kernel-tests 300 ./innergs_cuda_kernel_tests --gtest_brief=1
    INNERGS_TEST_PLUGIN=$PWD/plugin logged job-tests 300 ./innergs_cuda_job_tests --gtest_brief=1 ;;
  bench)
    nvidia-smi --query-gpu=timestamp,clocks.sm,clocks.mem,power.draw,temperature.gpu --format=csv -lms 500 \
      > "$results/clocks.csv" 2>&1 &
    watch=$!
    logged benchmark 500 ./innergs_cuda_benchmark "${volume[@]}" --output "$results/benchmark.md"
    kill $watch 2> /dev/null || true ;;
  sanitize)
    if ! command -v compute-sanitizer > /dev/null; then echo "compute-sanitizer is not installed"; exit 1; fi
    some='*Operations*Device*:*Reshaping*Device*:*Queries*Device*:*Kernels.*Device*'
    for tool in memcheck racecheck synccheck; do
      logged "$tool" 180 compute-sanitizer --tool $tool --error-exitcode 9 ./innergs_cuda_kernel_tests --gtest_brief=1 \
        --gtest_filter="$some"
    done ;;
  trial) # without a device: the same programs at a tiny size
    INNERGS_PLUGIN_PATH=$PWD/host-plugin logged trial 300 ./innergs_cuda_benchmark --host --repeats 1 --output "$results/trial.md" ;;
  *) echo "run.sh test|bench|sanitize|trial [FOLDER]"; exit 2 ;;
esac
exit $failed
RUN
chmod +x "$out/run.sh"
for f in "$out"/innergs_* "$out"/*/*.so; do strip --strip-unneeded "$f" 2> /dev/null || true; done
size=$(du -sm "$out" | cut -f1)
echo "$out: $size MiB"
[ "$size" -lt 60 ] || { echo "larger than 60 MiB: build fewer architectures (CMAKE_CUDA_ARCHITECTURES)" >&2; exit 1; }
