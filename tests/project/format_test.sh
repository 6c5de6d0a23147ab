#!/usr/bin/env bash
# Every C++ file is as clang-format would leave it, and every script passes shellcheck.
set -euo pipefail
cd "$(dirname "$(realpath "$0")")/../.."
find src apps bridges tests fuzz examples \( -name '*.h' -o -name '*.cpp' \) -print0 | xargs -0 clang-format --dry-run -Werror
shellcheck -x run test .ci/run tools/*.sh tests/project/*.sh
