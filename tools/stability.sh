#!/usr/bin/env bash
# Measures the contact stability of scenes, and writes the results for docs/stability.md: its figures,
# docs/images/stability-*.svg, and its tables, between the two marks in the page. Takes five minutes; ten with a scene.
#   tools/stability.sh [SCENE]    SCENE: a captured scene in addition to the built-in one
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -le 1 ]] || die "usage: tools/stability.sh [SCENE]"

page=$root/docs/stability.md
check_marks "$page"

ensure_packages "${build_packages[@]}"
ensure_npm
build_preset release OFF palpate_cli
palpate=$root/build/release/bin/palpate
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# measure NAME ARGS...: prints a heading and the output of palpate stability.
measure() {
  local name=$1
  shift
  say "palpate stability: $name"
  printf '\n### %s\n\n```text\n' "$name"
  "$palpate" stability "$@" | grep -v '^wrote ' | fold -s -w 120 | sed 's/ *$//'
  printf '```\n'
}

{
  printf '%s\n' "$(date -u +%Y-%m-%d)"
  measure 'The built-in scene' --svg "$root/docs/images"
  [[ $# -eq 0 ]] || measure "A capture: $(basename "$1")" "$1"
} >"$work/tables"
write_between_marks "$page" "$work/tables"
