#!/usr/bin/env bash
# Measures 1, 8 and 32 hands in one scene, in one process and in one process each, and writes the table of
# docs/network.md, between the two marks in the page. Takes three minutes, on an otherwise idle machine.
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -le 1 ]] || die "usage: tools/hands.sh [SCENE.ply]"

page=$root/docs/network.md
check_marks "$page"

ensure_packages "${build_packages[@]}"
ensure_npm
build_preset release OFF palpate_cli
palpate=$root/build/release/bin/palpate
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

scene=${1:-$work/still-life.ply}
[[ $# -eq 1 ]] || "$palpate" make-scene still-life --out "$scene" -q
gaussians=$("$palpate" info "$scene" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["gaussians"])')

{
  printf '%s\n\n' "$(processor), $(nproc) cores, load $(cut -d ' ' -f 1 /proc/loadavg) before, $gaussians Gaussians, $(date -u +%Y-%m-%d)"
  python3 "$root/tools/hands_rows.py" "$palpate" "$scene" "$work"
} >"$work/table"
write_between_marks "$page" "$work/table"
