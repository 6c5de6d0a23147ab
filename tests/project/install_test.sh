#!/usr/bin/env bash
# An installed Palpate can be found and used: builds examples/contacts, examples/embed and examples/plugin against it, touches a scene
# with each, and feels that as the device of examples/client.
# usage: install_test.sh BUILD_FOLDER
set -euo pipefail
build=$(realpath "${1:?usage: install_test.sh BUILD_FOLDER}")
root=$(dirname "$(realpath "$0")")/../..
work=$(mktemp -d)
trap '[[ -z ${run:-} ]] || kill "$run"; rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >/dev/null
cmake -S "$root/examples/contacts" -B "$work/example" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
cmake --build "$work/example" >/dev/null
"$work/prefix/bin/palpate" make-scene sphere --out "$work/sphere.ply" -q
answer=$("$work/example/contacts" "$work/sphere.ply" 0 0 0.18)
echo "$answer"
# 0.18 m up on a sphere of 0.15 m, the tool of 0.04 m half length reaches 10 mm in: it is pushed up.
[[ $answer =~ ([1-9][0-9]*)\ in\ contact.*\ ([0-9.]+)\ N$ ]]
cmake -S "$root/examples/embed" -B "$work/embed" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_CXX_FLAGS=-Werror >/dev/null
cmake --build "$work/embed" >/dev/null
answer=$("$work/embed/embed" "$work/sphere.ply" 0 0 0.15)
echo "$answer"
[[ $answer =~ ^[1-9][0-9]*\ ticks,\ up\ to\ [1-9][0-9]*\ contacts\ and\ [1-9][0-9.]*\ N$ ]]
answer=$("$work/embed/embed")
echo "$answer"
[[ $answer =~ up\ to\ [1-9][0-9]*\ contacts ]]
cmake -S "$root/examples/plugin" -B "$work/plugin" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS="-Wall -Wextra -Werror" >/dev/null
cmake --build "$work/plugin" >/dev/null
answer=$("$work/prefix/bin/palpate" run "$work/sphere.ply" --device "plugin:$work/plugin/pendulum.so:0.15" --seconds 2 --no-gateway -q --json)
[[ $answer =~ \"contacts_max\":\ *[1-9] ]]
cmake -S "$root/examples/client" -B "$work/client" -G Ninja -DCMAKE_CXX_FLAGS=-Werror >/dev/null
cmake --build "$work/client" >/dev/null
"$work/prefix/bin/palpate" run "$work/sphere.ply" --device client --port 0 --tool 0.02,0.02,0.02 >/dev/null 2>"$work/said" </dev/null &
run=$!
for _ in {1..300}; do
  port=$(sed -nE 's|.*http://127.0.0.1:([0-9]+)/.*|\1|p' "$work/said" | head -n 1)
  [[ -z $port ]] || break
  sleep 0.1
done
# It goes down to where the sphere is felt within two seconds, and again every four.
felt=$(timeout 60 "$work/client/palpate_client" 127.0.0.1 "$port" | grep -m 1 -E 'force +[1-9]' || true)
echo "$felt"
[[ -n $felt ]]
# The installed program's completion scripts load.
bash -n <("$work/prefix/bin/palpate" completion bash)
