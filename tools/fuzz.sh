#!/usr/bin/env bash
# Fuzzes every reader of the project for SECONDS each, one on each processor, under AddressSanitizer and UBSan; fails on
# any crash, hang or leak, and leaves the failing input in build/fuzz.
#   tools/fuzz.sh SECONDS [TARGET...]     targets: ply csv config materials tool index gateway
# Needs clang-16 and libclang-rt-16-dev.
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"

seconds=${1:-}
[[ $seconds =~ ^[1-9][0-9]*$ ]] || die "usage: tools/fuzz.sh SECONDS [TARGET...]"
shift
targets=("$@")
[[ $# -gt 0 ]] || targets=(ply csv config materials tool index gateway)
command -v clang++-16 >/dev/null || die "needs clang-16: apt-get install clang-16 libclang-rt-16-dev"

build=$root/build/fuzz
say "building build/fuzz"
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_COMPILER=clang++-16 \
  -DCMAKE_C_COMPILER=clang-16 \
  "-DCMAKE_CXX_FLAGS=-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -O1 -g1" \
  -DPALPATE_APPS=OFF -DPALPATE_TESTS=OFF -DPALPATE_FUZZ=ON "${unity[@]}" >/dev/null
cmake --build "$build" --target "${targets[@]/%/_fuzzer}" >&2

/usr/bin/python3 -B "$root/fuzz/make_seeds.py" "$build/seeds"
# fuzz TARGET
fuzz() {
  local target=$1
  say "fuzzing $target for $seconds s"
  mkdir -p "$build/corpus/$target"
  (cd "$build" && "./bin/${target}_fuzzer" "corpus/$target" "seeds/$target" "-max_total_time=$seconds" \
    -max_len=8192 -rss_limit_mb=1024 -timeout=10 "-artifact_prefix=$target-" -print_final_stats=1 -verbosity=1 \
    2>"$target.log") || {
    tail -n 40 "$build/$target.log" >&2
    die "$target: see $build/$target.log; the input is $build/$target-*"
  }
  say "$target: $(sed -n 's/^stat::\(number_of_executed_units\|peak_rss_mb\): */\1 /p' "$build/$target.log" | xargs)"
}
processors=$(nproc)
for ((first = 0; first < ${#targets[@]}; first += processors)); do
  running=()
  for target in "${targets[@]:first:processors}"; do
    fuzz "$target" &
    running+=($!)
  done
  for one in "${running[@]}"; do wait "$one"; done
done
say "no crash"
