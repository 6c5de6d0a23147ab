#!/usr/bin/env bash
# The viewer page in a real browser. usage: run.sh WORK_FOLDER VIEWER_FOLDER [PALPATE_BINARY]
# With the program, the page is tested against it, too.
set -euo pipefail
usage="usage: run.sh WORK_FOLDER VIEWER_FOLDER [PALPATE_BINARY]"
work=$(realpath -m "${1:?$usage}")
VIEWER_FOLDER=$(realpath "${2:?$usage}")
export VIEWER_FOLDER
tests=(viewer_test.mjs kept_test.mjs headset_test.mjs)
if [ $# -gt 2 ]; then
  PALPATE_BINARY=$(realpath "$3")
  export PALPATE_BINARY
  tests+=(program_test.mjs)
fi
mkdir -p "$work"
here=$(dirname "$(realpath "$0")")
cp "$here"/{package.json,package-lock.json,*.mjs} "$work"
cp "$here"/../../../web/viewer/src/{kept,haptics}.js "$work"
cd "$work"
# npm in a copy: the source tree stays as it is.
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --no-audit --no-fund --ignore-scripts
  cp package-lock.json installed-lock.json
fi
# One after the other: each has a browser that draws in software.
node --test --test-concurrency=1 "${tests[@]}"
