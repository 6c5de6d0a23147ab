#!/usr/bin/env bash
# Reproduces the paper's evaluation, and writes the results for docs/evaluation.md: its tables, between the two marks in
# the page, and docs/images/reproduce-*.svg. Takes ten minutes; more with a scene.
#   tools/evaluation.sh [SCENE]    SCENE: a captured scene in addition to the procedural one
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -le 1 ]] || die "usage: tools/evaluation.sh [SCENE]"

page=$root/docs/evaluation.md
check_marks "$page"

ensure_packages "${build_packages[@]}" libmujoco-dev python3
ensure_npm
build_preset release OFF palpate_cli
palpate=$root/build/release/bin/palpate
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# as_text HEADING ARGS...: prints a heading and the output of palpate reproduce.
as_text() {
  local heading=$1
  shift
  say "palpate reproduce: $heading"
  printf '\n### %s\n\n```text\n' "$heading"
  "$palpate" reproduce "$@" | grep -v '^wrote ' | fold -s -w 140 | sed 's/ *$//'
  printf '```\n'
}

# Hands from soft to stiff: m, b, k.
hands=('0.05,2,100' '0.1,3,200' '0.15,4,400' '0.2,6,700' '0.3,10,1000')

# operators: prints the table of both mechanics and all hands, with the worst of all places.
operators() {
  local plant hand
  printf '\n### Hands and mechanics\n\n'
  printf '| mechanics | hand: kg, N s/m, N/m | device | oscillation at rest, mm | overshoot, mm | user force deviation | force, N | net energy, mJ |\n'
  printf '|---|---|---|---|---|---|---|---|\n'
  for plant in own mujoco; do
    for hand in "${hands[@]}"; do
      say "palpate reproduce --plant $plant --hand $hand"
      "$palpate" reproduce --plant "$plant" --hand "$hand" --stall 0 --json >"$work/run.json"
      python3 "$root/tools/evaluation_rows.py" "$plant" "$hand" "$work/run.json"
    done
  done
}

{
  printf '%s\n' "$(date -u +%Y-%m-%d)"
  as_text 'A procedural truck' --svg "$root/docs/images"
  operators
  [[ $# -eq 0 ]] || as_text "A capture: $(basename "$1")" "$1"
} >"$work/tables"
write_between_marks "$page" "$work/tables"
