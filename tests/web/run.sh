#!/usr/bin/env bash
# The report page in a real browser. usage: run.sh WORK_FOLDER REPORT_PAGE
set -euo pipefail
work=$(realpath -m "${1:?usage: run.sh WORK_FOLDER REPORT_PAGE}")
REPORT_PAGE=$(realpath "${2:?usage: run.sh WORK_FOLDER REPORT_PAGE}")
export REPORT_PAGE
here=$(dirname "$(realpath "$0")")
# shellcheck source=tests/web/packages.sh
source "$here/packages.sh"
enter "$work" "$here"
node --test report_test.mjs
