#!/usr/bin/env bash
# The report page in a real browser. usage: run.sh WORK_FOLDER REPORT_PAGE
set -euo pipefail
work=$(realpath -m "${1:?usage: run.sh WORK_FOLDER REPORT_PAGE}")
REPORT_PAGE=$(realpath "${2:?usage: run.sh WORK_FOLDER REPORT_PAGE}")
export REPORT_PAGE
mkdir -p "$work"
cp "$(dirname "$(realpath "$0")")"/{package.json,package-lock.json,*.mjs} "$work"
cd "$work"
# npm in a copy: the source tree stays as it is.
if ! cmp -s package-lock.json installed-lock.json; then
  npm ci --no-audit --no-fund --ignore-scripts
  cp package-lock.json installed-lock.json
fi
node --test report_test.mjs
