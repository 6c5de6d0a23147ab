#!/usr/bin/env bash
# The viewer page in a real browser. usage: run.sh WORK_FOLDER VIEWER_FOLDER [PALPATE_BINARY]
# With the program, the page is tested against it, too.
set -euo pipefail
usage="usage: run.sh WORK_FOLDER VIEWER_FOLDER [PALPATE_BINARY]"
work=$(realpath -m "${1:?$usage}")
VIEWER_FOLDER=$(realpath "${2:?$usage}")
export VIEWER_FOLDER
tests=(kept_test.mjs page_test.mjs phone_test.mjs)
if [ $# -gt 2 ]; then
  PALPATE_BINARY=$(realpath "$3")
  export PALPATE_BINARY
  tests+=(program_test.mjs hands_test.mjs)
  # It takes minutes a scene.
  [ -z "${PALPATE_SCENES:-}${PALPATE_LONG:-}" ] || tests+=(first_contact_test.mjs)
fi
here=$(dirname "$(realpath "$0")")
# shellcheck source=tests/web/packages.sh
source "$here/../packages.sh"
enter "$work" "$here"
cp "$here"/../../../web/viewer/src/{extent,kept,ray_blocks,haptics,neighbourhood,parameters}.js .
# Two at a time: each has a browser that draws in software, and mostly waits for one core.
node --test --test-concurrency=2 "${tests[@]}"
