# A thin front: the work is in CMake and Utilities/. All set-up is included (Debian: apt, as root or through sudo).
PREFIX ?= /usr/local

.PHONY: build demo test bench asan tsan install clean dependencies

build: dependencies
	cmake --preset default --log-level=WARNING
	cmake --build --preset default --target innergs

demo: build
	Utilities/demo.sh build/bin/innergs demo

test: dependencies
	cmake --preset default --log-level=WARNING
	cmake --build --preset default
	ctest --preset default

bench: dependencies
	cmake --preset default -DINNERGS_BUILD_BENCHMARKS=ON --log-level=WARNING
	cmake --build --preset default --target bench

asan tsan: dependencies
	cmake --preset $@ --log-level=WARNING
	cmake --build --preset $@
	ctest --preset $@

install: build
	cmake --install build --prefix $(PREFIX)

dependencies:
	@Utilities/install-dependencies.sh

clean:
	rm -rf build build-asan build-tsan demo
