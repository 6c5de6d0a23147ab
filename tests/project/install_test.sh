#!/usr/bin/env bash
# An installed Palpate can be found and used: builds examples/contacts against it, touches a scene.
# usage: install_test.sh BUILD_FOLDER
set -euo pipefail
build=$(realpath "${1:?usage: install_test.sh BUILD_FOLDER}")
root=$(dirname "$(realpath "$0")")/../..
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >/dev/null
cmake -S "$root/examples/contacts" -B "$work/example" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
cmake --build "$work/example" >/dev/null
"$work/prefix/bin/palpate" make-scene sphere --out "$work/sphere.ply" -q
answer=$("$work/example/contacts" "$work/sphere.ply" 0 0 0.18)
echo "$answer"
# 0.18 m up on a sphere of 0.15 m, the tool of 0.04 m half length reaches 10 mm in: it is pushed up.
[[ $answer =~ ([1-9][0-9]*)\ in\ contact.*\ ([0-9.]+)\ N$ ]]
# The installed program's completion scripts load.
bash -n <("$work/prefix/bin/palpate" completion bash)
