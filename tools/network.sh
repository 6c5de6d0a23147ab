#!/usr/bin/env bash
# Measures the force rendered over a network, with device, collision and viewer on separate hosts (network namespaces of
# this machine), and writes the table of docs/network.md, between the two marks in the page. Takes six minutes, as root,
# on an otherwise idle machine.
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -eq 0 ]] || die "usage: tools/network.sh"

page=$root/docs/network.md
check_marks "$page"

ensure_packages "${build_packages[@]}" iproute2 curl
probe=palpate-$$-probe
if ! ip netns add "$probe" 2>/dev/null; then
  say "left out: network namespaces are not permitted here (they need root)"
  exit 0
fi
ip netns del "$probe"
ensure_npm
build_preset release OFF palpate_cli
palpate=$root/build/release/bin/palpate
work=$(mktemp -d)
token=0123456789abcdef
collision=10.78.1.1 device=10.78.1.2 collision_of_viewer=10.78.2.1

on() { ip netns exec "palpate-$$-$1" "${@:2}"; }
running=()
# start HOST OUTPUT COMMAND...: starts a command in the background, so that stop_all kills the command itself.
start() {
  : >"$2" # output of an earlier command must not satisfy await
  ip netns exec "palpate-$$-$1" "${@:3}" </dev/null >>"$2" 2>&1 &
  running+=($!)
}
stop_all() {
  local pid
  for pid in "${running[@]}"; do
    kill "$pid" 2>/dev/null || true
    wait "$pid" 2>/dev/null || true
  done
  running=()
}
# shellcheck disable=SC2317 # called by the trap
clean_up() {
  stop_all
  local host
  for host in device collision viewer; do ip netns del "palpate-$$-$host" 2>/dev/null || true; done
  rm -rf "$work"
}
trap clean_up EXIT

# link HOST ADDRESS PEER_ADDRESS: connects HOST to the collision host by a pair of virtual interfaces.
link() {
  ip link add "pp$1" netns "palpate-$$-$1" type veth peer name "pp$1" netns "palpate-$$-collision"
  on "$1" ip address add "$2/24" dev "pp$1"
  on collision ip address add "$3/24" dev "pp$1"
  on "$1" ip link set "pp$1" up
  on collision ip link set "pp$1" up
}
for host in device collision viewer; do
  ip netns add "palpate-$$-$host"
  on "$host" ip link set lo up
done
link device "$device" "$collision"
link viewer 10.78.2.2 "$collision_of_viewer"

g++ -std=c++20 -O2 -pthread -I"$root/examples" "$root/tests/network/hand.cpp" -o "$work/hand"
"$palpate" make-scene plane --out "$work/plane.ply" -q

# await FILE TEXT: waits until a started program has printed TEXT to FILE.
await() {
  local k
  for ((k = 0; k < 300; ++k)); do
    grep -q "$2" "$1" && return
    sleep 0.1
  done
  die "a program does not start: $(tail -n 1 "$1")"
}

# trial RATE DELAY JITTER LOSS KIND [COMMAND]: prints the results of tests/network/hand.cpp; DELAY in ms, each way.
trial() {
  start collision "$work/palpate" "$palpate" run "$work/plane.ply" --device client --client-rate "$1" --tool 0.02,0.02,0.02 \
    --listen 0.0.0.0 --token "$token"
  await "$work/palpate" http
  start device "$work/relay" python3 "$root/tests/network/relay.py" 127.0.0.1 9090 "$collision" 9090 "$2" "$3" "$4"
  await "$work/relay" ready
  on viewer curl -sSf -o /dev/null -H "Authorization: Bearer $token" "http://$collision_of_viewer:9090/"
  on device "$work/hand" 127.0.0.1 9090 "$token" "$5" 0.02 "${@:6}" || true
  stop_all
}

# row NAME RATE DELAY JITTER LOSS: prints the table rows of a link, one per kind of force.
row() {
  local kind drops peak rest port age50 age99 stiffness lasts
  for kind in wrench local; do
    say "$1, $kind"
    read -r drops peak rest port age50 age99 stiffness lasts < <(trial "${@:2}" "$kind" \
      "ip netns exec palpate-$$-collision ip link set ppdevice down")
    on collision ip link set ppdevice up
    printf '| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n' "$1" "$2" "$kind" "$age50" "$age99" "$stiffness" "$peak" \
      "$rest" "$port" "$drops" "$lasts"
  done
}

{
  printf '%s\n\n' "$(processor), $(nproc) cores, $(date -u +%Y-%m-%d)"
  printf '| link, each way | poses/s | force | age p50 ms | p99 | rendered N/m | at rest µm | net output at rest, mJ | total net output, mJ | drops | cut, to zero ms |\n'
  printf '|---|---|---|---|---|---|---|---|---|---|---|\n'
  row '0 ms' 1000 0 0 0
  row '1 ms' 1000 1 0 0
  row '1 ms, jitter 2 ms' 1000 1 2 0
  row '1 ms, loss 1 %' 1000 1 0 1
  row '5 ms' 1000 5 0 0
  row '5 ms, jitter 2 ms' 1000 5 2 0
  row '5 ms, loss 1 %' 1000 5 0 1
  row '20 ms' 60 20 0 0
  row '20 ms, jitter 2 ms' 60 20 2 0
  row '20 ms, loss 1 %' 60 20 0 1
} >"$work/table"
write_between_marks "$page" "$work/table"
