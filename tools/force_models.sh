#!/usr/bin/env bash
# Measures the force models and writes the results for docs/force-models.md: its figures, docs/images/evaluate-*.svg,
# and its tables, between the two marks in the page. Takes five minutes, on an otherwise idle machine.
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -eq 0 ]] || die "usage: tools/force_models.sh"

page=$root/docs/force-models.md
check_marks "$page"

ensure_packages "${build_packages[@]}"
ensure_npm
build_preset release OFF palpate_cli
palpate=$root/build/release/bin/palpate
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

say "palpate evaluate"
"$palpate" evaluate --csv "$work/all.csv" --svg "$root/docs/images" >/dev/null
say "palpate evaluate, many pushes"
"$palpate" evaluate --models proxy --spacings 0.006 --scenes 10 --places 10 --pushes 1430 --csv "$work/pushes.csv" >/dev/null

# table CSV CONDITION "HEADING=COLUMN:FORMAT"...: prints the rows for which the awk CONDITION on value(COLUMN) holds.
table() {
  local csv=$1 condition=$2 heads='' rules='' values='' spec
  shift 2
  for spec in "$@"; do
    heads+=" ${spec%%=*} |"
    rules+='---|'
    spec=${spec#*=}
    values+=", text(\"${spec%%:*}\", \"${spec#*:}\")"
  done
  printf '| shape | spacing mm | model |%s\n|---|---|---|%s\n' "$heads" "$rules"
  awk -F, '
    function value(name) { return $column[name] }
    function text(name, format) { return value(name) == "" ? "- |" : sprintf(format " |", value(name)) }
    function line(a, b, c, d, e, f, g, h, i, j, k, l, m, n) { print a, b, c, d, e, f, g, h, i, j, k, l, m, n }
    /^#/ { next }
    !named++ { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    '"$condition"' { line(sprintf("| %s | %g | %s |", $1, 1000 * $2, $3)'"$values"') }' "$csv" | sed 's/ *$//'
}

write_tables() {
  printf '%s\n\n' "$(processor), $(date -u +%Y-%m-%d)"
  table "$work/all.csv" 1 'direction p50 deg=direction_p50_deg:%.1f' 'p95=direction_p95_deg:%.1f' \
    'F / (k depth)=magnitude_p50:%.2f' 'below the visible surface=magnitude_seen_p50:%.2f' 'visible surface at mm=seen_p50_mm:%.1f' \
    'ripple=ripple_p50:%.3f' 'jump N=jump_max_n:%.3f' 'loop=loop_p50:%.0e' \
    'through of 100=through:%d' 'friction of 0.3=friction_p50:%.2f' 'F / F at 6 mm=force_ratio_p50:%.2f' \
    'tick p50 us=tick_p50_us:%.0f' 'p99=tick_p99_us:%.0f'
  printf '\nCrossing of a step of 3 mm by a ball of 5 mm:\n\n'
  table "$work/all.csv" 'value("step_p50_mm") != ""' 'rise p50 mm=step_p50_mm:%.2f' 'over mm=step_over_p50_mm:%.1f' \
    'with noise: rise p50 mm=noisy_step_p50_mm:%.2f' 'p95=noisy_step_p95_mm:%.2f'
  printf '\nCrossing of an edge of 90 degrees:\n\n'
  table "$work/all.csv" 'value("edge_off_p50_mm") != ""' 'deviation p50 mm=edge_off_p50_mm:%.2f' \
    'max mm=edge_off_max_mm:%.2f' 'position mm=edge_where_mm:%.1f'
  printf '\nMany pushes:\n\n'
  table "$work/pushes.csv" 1 'pushes=pushes:%d' 'through=through:%d' 'of them at 2 m/s=fast:%d' 'through=fast_through:%d'
}

write_tables >"$work/tables"
write_between_marks "$page" "$work/tables"
