# A thin front end to CMake and Utilities/. Every target installs what it needs (Debian: apt, as root or through sudo).
PREFIX ?= /usr/local
# Further arguments of CMake for build and test, e.g. -DCMAKE_CUDA_ARCHITECTURES=90.
CMAKE_ARGS ?=

.PHONY: build demo test test-locale bench asan tsan mrml mrml-asan bench-mrml slicer test-cuda bench-cuda cuda-bundle app screenshots install clean dependencies

build: dependencies
	cmake --preset default $(CMAKE_ARGS) --log-level=WARNING
	cmake --build --preset default --target innergs innergs_plugins

demo: build
	Utilities/demo.sh build/bin/innergs demo

# Networks are tested where OpenVINO is there or can be fetched; otherwise those tests say that they were skipped.
test: export INNERGS_OPENVINO ?= $(CURDIR)/build/openvino
test: dependencies
	cmake --preset default $(CMAKE_ARGS) --log-level=WARNING
	cmake --build --preset default
	@Utilities/fetch-openvino.sh build/openvino
	ctest --preset default

# Runs the tests in a host with a decimal comma; after `make test`.
test-locale: dependencies
	@rm -f build/skipped-locale
	@Utilities/make-locale.sh build/locales || { [ $$? = 3 ] && touch build/skipped-locale; }
	@if [ -e build/skipped-locale ]; then \
	  echo '**** SKIPPED: the tests were not run with a decimal comma, for the reason above. ****' >&2; else \
	  ctest --preset decimal-comma; fi

# Builds and starts the desktop app. With files: build/bin/innergs-app FILES...
app: dependencies
	cmake --preset default --log-level=WARNING
	cmake --build --preset default --target innergs_app innergs_plugins
	build/bin/innergs-app

screenshots: dependencies
	cmake --preset default --log-level=WARNING
	cmake --build --preset default --target innergs_screenshots
	Utilities/screenshots.sh build/bin/innergs_screenshots Docs/screenshots

bench: dependencies
	cmake --preset default -DINNERGS_BUILD_BENCHMARKS=ON --log-level=WARNING
	cmake --build --preset default --target bench

asan tsan: dependencies
	cmake --preset $@ --log-level=WARNING
	cmake --build --preset $@
	ctest --preset $@

# The CUDA plugin (Docs/cuda.md): compiled if nvcc is found, run if there is a device; otherwise says so.
test-cuda: dependencies
	cmake --preset cuda --log-level=WARNING
	cmake --build --preset cuda --target innergs_cuda innergs_cuda_kernel_tests innergs_cuda_tests
	build-cuda/bin/innergs_cuda_tests
	build-cuda/bin/innergs_cuda_kernel_tests

# INNERGS_BRAINWEB: an uncompressed .nii volume to measure on; default: a synthetic one.
bench-cuda: dependencies
	cmake --preset cuda -DINNERGS_BUILD_BENCHMARKS=ON --log-level=WARNING
	cmake --build --preset cuda --target innergs_cuda innergs_cuda_benchmark
	INNERGS_PLUGIN_PATH=build-cuda/lib build-cuda/bin/innergs_cuda_benchmark --output build-cuda/benchmark.md

# For a machine with a GPU but without these tools: build-cuda-bundle/run.sh test|bench|sanitize (Docs/cuda.md).
cuda-bundle: dependencies
	cmake --preset cuda -DINNERGS_BUILD_BENCHMARKS=ON --log-level=WARNING
	cmake --build --preset cuda --target innergs_cuda innergs_cuda_kernel_tests innergs_cuda_tests innergs_cuda_benchmark \
	  innergs_cuda_job_tests innergs_host_plugin
	Utilities/cuda-bundle.sh build-cuda build-cuda-bundle "$(INNERGS_BRAINWEB)"

# Against Slicer's own libraries from PyPI; if they are unavailable, says so and continues.
mrml: dependencies
	@mkdir -p build-mrml && rm -f build-mrml/skipped
	@Utilities/fetch-slicer-core.sh build-mrml/slicer-core || { [ $$? = 3 ] && touch build-mrml/skipped; }
	@if [ -e build-mrml/skipped ]; then \
	  echo '**** SKIPPED: the MRML layer was not built and not tested, for the reason above. ****' >&2; else \
	  cmake --preset mrml --log-level=WARNING && cmake --build --preset mrml && ctest --preset mrml; fi

# The same under the address sanitizer; after `make mrml`, skipped if that was skipped.
mrml-asan: dependencies
	@if [ -e build-mrml/skipped ] || [ ! -e build-mrml/slicer-core/complete ]; then \
	  echo '**** SKIPPED: the MRML layer was not tested under sanitizers: make mrml has not built it. ****' >&2; else \
	  cmake --preset mrml-asan --log-level=WARNING && cmake --build --preset mrml-asan && ctest --preset mrml-asan; fi

bench-mrml: dependencies
	Utilities/fetch-slicer-core.sh build-mrml/slicer-core
	cmake --preset mrml --log-level=WARNING
	cmake --build --preset mrml --target bench_mrml

# The loadable module in a real Slicer (Slicer_DIR: its build tree); without one, says so and continues.
slicer: dependencies
	@mkdir -p build-slicer && rm -f build-slicer/skipped
	@Utilities/test-extension.sh build-slicer || { [ $$? = 3 ] && touch build-slicer/skipped; }
	@if [ -e build-slicer/skipped ]; then \
	  echo '**** SKIPPED: the Slicer module was not built and not tested, for the reason above. ****' >&2; fi

install: build
	cmake --install build --prefix $(PREFIX)

dependencies:
	@Utilities/install-dependencies.sh

clean:
	rm -rf build build-asan build-tsan build-mrml build-mrml-asan build-slicer build-cuda build-cuda-bundle demo
