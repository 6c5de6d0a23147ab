#!/usr/bin/env bash
# clang-tidy finds nothing in the library and the program. usage: tidy_test.sh BUILD_FOLDER
set -euo pipefail
build=$(realpath "${1:?usage: tidy_test.sh BUILD_FOLDER}")
cd "$(dirname "$(realpath "$0")")/../.."
find src apps -name '*.cpp' -print0 | xargs -0 -P "$(nproc)" -n 2 clang-tidy -p "$build" --quiet
