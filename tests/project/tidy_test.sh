#!/usr/bin/env bash
# clang-tidy finds nothing in the given folders. usage: tidy_test.sh BUILD_FOLDER FOLDER...
set -euo pipefail
build=$(realpath "${1:?usage: tidy_test.sh BUILD_FOLDER FOLDER...}")
shift
cd "$(dirname "$(realpath "$0")")/../.."
# Without GCC's precompiled headers, which clang cannot read: so what a source forgot to include is found, too.
commands=$(mktemp -d)
trap 'rm -rf "$commands"' EXIT
sed 's/ -Winvalid-pch -include [^ ]*cmake_pch.hxx / /' "$build/compile_commands.json" >"$commands/compile_commands.json"
find "$@" -name '*.cpp' -print0 | xargs -0 -P "$(nproc)" -n 2 clang-tidy -p "$commands" --quiet
