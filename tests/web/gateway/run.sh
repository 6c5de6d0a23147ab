#!/usr/bin/env bash
# roslib against the program. usage: run.sh WORK_FOLDER PALPATE
set -euo pipefail
work=$(realpath -m "${1:?usage: run.sh WORK_FOLDER PALPATE}")
PALPATE=$(realpath "${2:?usage: run.sh WORK_FOLDER PALPATE}")
export PALPATE
mkdir -p "$work"
cp "$(dirname "$(realpath "$0")")"/{package.json,package-lock.json,*.mjs} "$work"
cd "$work"
# npm in a copy: the source tree stays as it is.
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --no-audit --no-fund --ignore-scripts
  cp package-lock.json installed-lock.json
fi
# roslib wants Node 20; Debian 12 has 18, and npm has the other.
node=(node)
[[ $(node -p 'process.versions.node.split(".")[0]') -ge 20 ]] || node=(npx -y -p node@20 node)
"${node[@]}" --test --test-timeout=300000 gateway_test.mjs
