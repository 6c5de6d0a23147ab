#!/usr/bin/env bash
# clang-tidy finds nothing in the given folders. usage: tidy_test.sh BUILD_FOLDER FOLDER...
set -euo pipefail
build=$(realpath "${1:?usage: tidy_test.sh BUILD_FOLDER FOLDER...}")/tidy
shift
cd "$(dirname "$(realpath "$0")")/../.."
# A folder in which every source is compiled by itself, with all that it includes.
cmake --preset release -B "$build" >/dev/null
find "$@" -name '*.cpp' -print0 | xargs -0 -P "$(nproc)" -n 2 clang-tidy -p "$build" --quiet
