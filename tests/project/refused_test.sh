#!/usr/bin/env bash
# The compiler refuses what would mix up frames, and names the type. usage: refused_test.sh COMPILER FLAG...
set -euo pipefail
source=$(dirname "$(realpath "$0")")/refused/device_pose_as_world_pose.cpp
said=$(mktemp)
trap 'rm -f "$said"' EXIT

compile() { LC_ALL=C "$@" -std=c++20 -fsyntax-only "$source"; }

# As it should be written: what is refused below is refused for no other reason.
compile "$@"
if compile "$@" -DREFUSED 2>"$said"; then
  echo "a reading of a device is taken for a pose of the world" >&2
  exit 1
fi
grep -q 'DevicePose' "$said" || { cat "$said" >&2; exit 1; }
[ "$(grep -c 'error:' "$said")" -eq 1 ] || { cat "$said" >&2; exit 1; }
