#!/usr/bin/env bash
# The bridge to ROS 2 against a peer on another DDS. usage: run.sh WORK_FOLDER TEST.mjs...
set -euo pipefail
work=$(realpath -m "${1:?usage: run.sh WORK_FOLDER TEST.mjs...}")
here=$(dirname "$(realpath "$0")")
# shellcheck source=tests/web/packages.sh
source "$here/../../web/packages.sh"
enter "$work" "$here"
for test in "${@:2}"; do node --test "$test"; done
