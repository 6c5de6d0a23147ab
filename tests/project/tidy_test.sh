#!/usr/bin/env bash
# clang-tidy 14 finds nothing in the given folders (skipped with another: each has more checks than the one before).
# usage: tidy_test.sh BUILD_FOLDER [--joined] FOLDER...
#   --joined: reads the sources of each library, src/palpate/FOLDER, as one: several times faster, as headers are read once
set -euo pipefail
usage='usage: tidy_test.sh BUILD_FOLDER [--joined] FOLDER...'
build=$(realpath "${1:?$usage}")/tidy
shift
[[ $(clang-tidy --version) == *"version 14."* ]] || exit 77
cd "$(dirname "$(realpath "$0")")/../.."
# A build folder of its own, so that all sources are compiled in the way that they are to be read.
if [[ ${1:?$usage} == --joined ]]; then
  shift
  cmake --preset release -B "$build" -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 >/dev/null
  for folder in "$@"; do
    clang-tidy -p "$build" --quiet --checks=-bugprone-suspicious-include --header-filter='(src|apps)/palpate/' \
      "$build/src/palpate/CMakeFiles/palpate_$(basename "$folder").dir"/Unity/*.cxx
  done
else
  cmake --preset release -B "$build" -DCMAKE_UNITY_BUILD=OFF >/dev/null
  # Headers that are generated.
  ninja -C "$build" -t targets rule CUSTOM_COMMAND | sed -n '/\.h$/p' | xargs -r ninja -C "$build" >/dev/null
  find "$@" -name '*.cpp' -print0 | xargs -0 -P "$(nproc)" -n 2 clang-tidy -p "$build" --quiet
fi
