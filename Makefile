# make demo   install, build and run the demo
# make test   install, build and run all tests
# packages.txt lists everything that is installed.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
PROGRAM := build/release/pickbed
PARTS := build/release/pickbed_make_parts
# Real meshes and frames next to the repository. Without them some tests are skipped.
TEST_DATA := $(or $(wildcard $(abspath ../shared/data)),$(abspath tests/data))
AS_ROOT := $(shell [ "$$(id -u)" = 0 ] || echo sudo)

# $(call install,groups): installs the missing packages of these groups in packages.txt. A package that
# another one provides is not missing (nodejs from NodeSource provides npm).
define install
	@missing=""; \
	here=" $$(dpkg-query -W -f '$${db:Status-Status} $${Package} $${Provides}\n' | sed -n 's/^installed//; T; s/([^)]*)//g; s/,/ /g; p' | tr '\n' ' ') "; \
	for package in $$(awk -v groups="$(1)" '/^[a-z]/ && index(groups, $$1) { print $$2 }' packages.txt); do \
	  [[ "$$here" == *" $$package "* ]] || missing="$$missing $$package"; \
	done; \
	if [ -n "$$missing" ]; then \
	  echo "installing:$$missing"; \
	  $(AS_ROOT) apt-get update -q; \
	  DEBIAN_FRONTEND=noninteractive $(AS_ROOT) apt-get install -q -y --no-install-recommends $$missing; \
	fi
endef

.PHONY: help build demo test fuzz docs format parts install clean

help:
	@sed -n 's/^# \(make .*\)/\1/p' Makefile

build:
	$(call install,build plugin report)
	cmake --preset release -DPICKBED_BUILD_TESTS=OFF
	cmake --build --preset release

demo: build
	rm -rf results/demo
	$(PROGRAM) run scenes/presets/demo.yaml --jobs $$(nproc) --out results/demo
	-$(PROGRAM) report results/demo

test:
	$(call install,build plugin report test)
	cmake --preset release -DPICKBED_BUILD_TESTS=ON -DPICKBED_TEST_DATA=$(TEST_DATA)
	cmake --build --preset release
	ctest --preset release -j $$(nproc)

# make fuzz MINUTES=30   run all fuzz targets with libFuzzer and the sanitizers
MINUTES ?= 30
fuzz:
	$(call install,build plugin report test fuzz)
	cmake --preset fuzz
	cmake --build --preset fuzz
	tests/fuzz/fuzz.sh $(MINUTES)

# make docs    build the documentation site and the API reference: build/docs/site/index.html
docs:
	-$(call install,docs)
	@for program in mkdocs doxygen; do \
	  command -v $$program >/dev/null || { echo "the package $$program is missing; see group docs in packages.txt" >&2; exit 1; }; \
	done
	mkdocs build --strict --quiet -f docs/mkdocs.yml
	doxygen docs/doxygen/Doxyfile

# make format  format the sources with clang-format
format:
	git ls-files '*.h' '*.cpp' | xargs clang-format-14 -i

# make parts   regenerate assets/objects from the part families
parts: build
	$(PARTS) assets/objects

# make install PREFIX=/usr/local   install program, assets, presets, C++ libraries and their headers
PREFIX ?= /usr/local
install: build
	cmake build/release -DCMAKE_INSTALL_PREFIX=$(abspath $(PREFIX))
	cmake --build --preset release
	cmake --install build/release

clean:
	rm -rf build results
