# geodesicd: what there is to do. The work is in scripts/ and CMakePresets.json.

PORT ?= 8080
HOST ?= 127.0.0.1
SECONDS ?= 60
JOBS ?= $(shell nproc)
export PORT HOST JOBS

.DEFAULT_GOAL := help
.PHONY: help setup configure build run test test-s3 test-cluster scaling test-crash test-bulk test-packages test-image deb wheels release docs bench paper load torture fuzz format lint clean
MAKEFLAGS += --no-print-directory

help: ## list these targets
	@sed -n 's/^\([a-z0-9-]*\):.*## \(.*\)/  make \1|\2/p' Makefile | column -t -s '|'
	@echo "Variables: HOST=$(HOST) PORT=$(PORT) (run), SECONDS=$(SECONDS) (fuzz), JOBS=$(JOBS)"

setup: ## install what building needs (Debian 12 or 13; root or sudo)
	@scripts/setup

configure: setup
	@cmake --preset release -Wno-dev --log-level=WARNING $(CMAKE_FLAGS)

build: configure ## build everything for release, in build/release
	@cmake --build --preset release --parallel $(JOBS)

run: ## build and start the server, viewer and sample meshes; Ctrl-C stops it
	@scripts/build_and_run $(CMAKE_FLAGS)

test: ## build and run all tests, again under the sanitizers, and the fuzzers for seconds
	@scripts/setup fuzz
	@scripts/run_tests

test-s3: build ## test the store in object storage, against OpenStack Swift
	@scripts/setup s3
	@ctest --test-dir build/release --tests-regex '^s3_test$$' --verbose

test-cluster: build ## test three servers behind nginx and HAProxy while servers go and come, warm starts, and the simulation of fleets
	@scripts/setup s3
	@ctest --test-dir build/release --tests-regex '^fleet_test$$' --verbose
	@tests/cluster/tags_test.py build/release/geodesicd
	@tests/cluster/in_simpy.sh events_test.py build/release/geodesicd
	@tests/cluster/in_simpy.sh warm_start.py build/release/geodesicd
	@tests/cluster/in_simpy.sh check_simulation.py build/release/geodesicd

scaling: build ## measure what queries cost, and simulate fleets of up to 1,000 servers, in build/scaling (minutes)
	@scripts/setup paper
	@scripts/simulate_fleets

test-crash: build ## kill the server 200 times while it writes
	@tests/crash/crash_test.py build/release/geodesicd 200

test-bulk: build ## map 200 meshes by Dask, while workers, servers and runs are killed
	@GEODESICD_BULK_MESHES=200 tests/clients/python_test.sh build/release/geodesicd -- tests/test_bulk.py

docs: ## build the documentation site, static files, in build/docs
	@scripts/setup
	@scripts/build_docs

deb: ## build Debian's package for the Debian that this is, in build/dist
	@scripts/build_deb

wheels: ## build the wheels of the Python client and of the server, in build/dist
	@scripts/build_wheels

release: ## build all that is shipped, with checksums, in build/dist
	@scripts/build_release

test-packages: wheels ## test the packages in clean Debian 12 and 13 roots (root, debootstrap; minutes)
	@tests/packages/debian_test.sh
	@tests/packages/wheels_test.sh

test-image: ## build the image twice: the same file system, small, with its SBOM (root, debootstrap, buildah; minutes)
	@scripts/setup image
	@tests/packages/image_test.sh

bench: build ## measure every method, and other people's, in build/bench (minutes)
	@scripts/setup bench
	@scripts/run_bench

paper: build ## reproduce the paper, in build/paper and docs/paper (minutes)
	@scripts/setup paper
	@scripts/write_paper

load: build ## load the server for some minutes and compare with what was asked
	@scripts/setup load
	@scripts/run_load

torture: build ## ask everything at once and at random for ten minutes
	@tests/load/torture.py build/release

fuzz: ## run each fuzzer for SECONDS
	@scripts/setup fuzz
	@scripts/run_fuzzers $(SECONDS)

format: ## apply .clang-format to our sources
	@scripts/setup lint
	@scripts/list_sources | xargs clang-format -i

lint: ## clang-format, clang-tidy and shellcheck, changing nothing
	@scripts/setup lint
	@scripts/lint

clean: ## remove everything that was built
	@rm -rf build
