#!/usr/bin/env bash
# Measures the gateway with real clients and writes the tables of docs/gateway.md, between the two marks in the page.
# Takes twelve minutes, on an otherwise idle machine.
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -eq 0 ]] || die "usage: tools/gateway.sh"

page=$root/docs/gateway.md
check_marks "$page"

ensure_packages "${build_packages[@]}"
ensure_npm
build_preset release OFF palpate_cli
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
run=$root/tests/web/gateway/run.sh

{
  printf '%s\n' "$(processor), $(nproc) cores, $(date -u +%Y-%m-%d)"
  for script in latency load; do
    say "tests/web/gateway/$script.mjs" >&2
    printf '\n'
    "$run" "$work/node" "$root/build/release/bin/palpate" "$script.mjs" | grep '^|'
  done
} >"$work/tables"
write_between_marks "$page" "$work/tables"
