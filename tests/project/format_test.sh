#!/usr/bin/env bash
# Every script passes shellcheck, and every C++ file is as clang-format 14 would leave it (skipped with another: they differ).
set -euo pipefail
cd "$(dirname "$(realpath "$0")")/../.."
shellcheck -x run test .ci/run tools/*.sh tests/project/*.sh
[[ $(clang-format --version) == *"version 14."* ]] || exit 77
find src apps bridges tests fuzz examples \( -name '*.h' -o -name '*.cpp' \) -print0 | xargs -0 clang-format --dry-run -Werror
