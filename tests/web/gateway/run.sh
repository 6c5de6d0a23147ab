#!/usr/bin/env bash
# roslib against the program. usage: run.sh WORK_FOLDER PALPATE [SCRIPT ARGS...]
set -euo pipefail
work=$(realpath -m "${1:?usage: run.sh WORK_FOLDER PALPATE [SCRIPT ARGS...]}")
PALPATE=$(realpath "${2:?usage: run.sh WORK_FOLDER PALPATE [SCRIPT ARGS...]}")
export PALPATE
here=$(dirname "$(realpath "$0")")
# shellcheck source=tests/web/packages.sh
source "$here/../packages.sh"
enter "$work" "$here"
# roslib wants Node 20; Debian 12 has 18, and npm has the other.
node=(node)
[[ $(node -p 'process.versions.node.split(".")[0]') -ge 20 ]] || node=(npx -y -p node@20 node)
if [[ $# -gt 2 ]]; then
  "${node[@]}" "${@:3}"
else
  "${node[@]}" --test --test-timeout=300000 gateway_test.mjs
fi
