#!/usr/bin/env bash
# Measures how firmly scenes can be held on to, and writes what docs/stability.md says about it: its figures,
# docs/images/stability-*.svg, and its tables, between the two marks in the page. Takes five minutes; ten with a scene.
#   tools/stability.sh [SCENE]    a captured scene besides the built-in one
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -le 1 ]] || die "usage: tools/stability.sh [SCENE]"

page=$root/docs/stability.md
begin='<!-- written by tools/stability.sh: begin -->'
end='<!-- written by tools/stability.sh: end -->'
for mark in "$begin" "$end"; do
  [[ $(grep -cxF "$mark" "$page") -eq 1 ]] || die "$page has not one line '$mark'"
done

ensure_packages "${build_packages[@]}"
ensure_npm
build_preset release OFF palpate_cli
palpate=$root/build/release/bin/palpate
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# measure NAME ARGS...: a heading, and what palpate stability prints.
measure() {
  local name=$1
  shift
  say "palpate stability: $name"
  printf '### %s\n\n```text\n' "$name"
  "$palpate" stability "$@" | grep -v '^wrote ' | fold -s -w 120 | sed 's/ *$//'
  printf '```\n\n'
}

{
  printf '%s\n\n' "$(date -u +%Y-%m-%d)"
  measure 'The built-in scene' --svg "$root/docs/images"
  [[ $# -eq 0 ]] || measure "A capture: $(basename "$1")" "$1"
} >"$work/tables"
awk -v begin="$begin" -v end="$end" -v tables="$work/tables" '
  $0 == end { inside = 0 }
  !inside { print }
  $0 == begin { inside = 1; print ""; while ((getline line < tables) > 0) print line }' "$page" >"$work/page"
cp "$work/page" "$page"
say "wrote $page"
