# make demo   install, build and run the demo
# make test   install, build and run all tests
# Everything that is installed stands in packages.txt.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
PROGRAM := build/release/pickbed
PARTS := build/release/scenes/pickbed_make_parts
AS_ROOT := $(shell [ "$$(id -u)" = 0 ] || echo sudo)

# $(call install,groups): installs what is missing of these groups of packages.txt; what another
# package provides (nodejs of NodeSource has npm) is not missing.
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

.PHONY: help build demo test format parts install clean

help:
	@sed -n 's/^# \(make .*\)/\1/p' Makefile

build:
	$(call install,build report)
	cmake --preset release -DPICKBED_BUILD_TESTS=OFF
	cmake --build --preset release

demo: build
	rm -rf results/demo
	$(PROGRAM) run scenes/presets/demo.yaml --jobs $$(nproc) --out results/demo
	-$(PROGRAM) report results/demo

test:
	$(call install,build report test)
	cmake --preset release -DPICKBED_BUILD_TESTS=ON
	cmake --build --preset release
	ctest --preset release -j $$(nproc)

# make format  rewrite the sources as clang-format wants them
format:
	git ls-files '*.h' '*.cpp' | xargs clang-format-14 -i

# make parts   write assets/objects anew from the part families
parts: build
	$(PARTS) assets/objects

# make install PREFIX=/usr/local   install program, assets and presets
PREFIX ?= /usr/local
install: build
	cmake --install build/release --prefix $(PREFIX)

clean:
	rm -rf build results
