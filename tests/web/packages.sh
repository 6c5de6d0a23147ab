# shellcheck shell=bash
# Sourced by the run.sh of the tests of pages.

# enter WORK_FOLDER SOURCE_FOLDER: goes to the former, with a copy of the tests of the latter, of how they start the browser, and
# their packages in it: npm must leave the source tree as it is.
enter() {
  mkdir -p "$1"
  cp "$(dirname "${BASH_SOURCE[0]}")/chromium.mjs" "$2"/{package.json,package-lock.json} "$1"
  cp "$2"/*.mjs "$1"
  cd "$1" || exit
  cmp -s package-lock.json installed-lock.json && return
  npm ci --no-audit --no-fund --ignore-scripts
  cp package-lock.json installed-lock.json
}
