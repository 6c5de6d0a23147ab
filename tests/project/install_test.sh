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
# Whichever way it ends while it presses, the last that its motors are told is zero.
presses_until() { # COMMAND...
  "$work/client/palpate_client" 127.0.0.1 "$port" >"$work/felt" 2>/dev/null &
  local client=$!
  for _ in {1..300}; do
    [[ $(tail -n 1 "$work/felt") =~ force\ +[1-9] ]] && break
    sleep 0.1
  done
  "$@" "$client"
  wait "$client" || true
  tail -n 1 "$work/felt"
  [[ $(tail -n 1 "$work/felt") == "the motors show 0.00 N" ]]
}
kill_program() {
  kill -KILL "$run"
  run=
}
presses_until kill -TERM
sleep 2 # until the program lets go of the tool
presses_until kill_program

# A consumer of `collision` alone gets the same contacts, bit by bit, whatever it is compiled with, and needs none of the other packages.
alone=(--no-warn-unused-cli -G Ninja "-DCMAKE_PREFIX_PATH=$work/prefix")
for package in Boost OpenSSL nlohmann_json orocos_kdl urdfdom console_bridge; do alone+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
contacts_of() { # NAME CMAKE_OPTION...
  cmake -S "$root/tests/project/consumer" -B "$work/$1" "${alone[@]}" "${@:2}" >/dev/null
  cmake --build "$work/$1" >/dev/null
  "$work/$1/consumer" "$work/sphere.ply"
}
expected=$(contacts_of plain)
[[ $(wc -l <<<"$expected") -gt 100 ]]
[[ $(contacts_of native -DCMAKE_CXX_STANDARD=23 "-DCMAKE_CXX_FLAGS=-march=native -O2") == "$expected" ]]
[[ $(contacts_of clang -DCMAKE_CXX_COMPILER=clang++) == "$expected" ]]
load='import ctypes, sys; ctypes.CDLL(sys.argv[1]).touch(sys.argv[2].encode())'
[[ $(python3 -c "$load" "$work/plain/libtouch.so" "$work/sphere.ply") == "$expected" ]]
# A part of another project, as shared libraries.
if [[ -n ${PALPATE_LONG:-} ]]; then
  shared=$(alone=(-G Ninja) contacts_of shared "-DPALPATE_SOURCE=$root" -DBUILD_SHARED_LIBS=ON -DCMAKE_BUILD_TYPE=Release)
  [[ $shared == "$expected" ]]
fi
# Where Eigen is aligned otherwise than in the library, linking fails and says so.
if [[ $(uname -m) == x86_64 ]]; then
  g++ -std=c++20 -mavx -c -I"$work/prefix/include" -I/usr/include/eigen3 "$root/tests/project/consumer/touch.cpp" -o "$work/avx.o"
  said=$(g++ "$root/tests/project/consumer/main.cpp" "$work/avx.o" -L"$work/prefix/lib" -lpalpate_{collision,scene,geometry,base} 2>&1 || true)
  [[ $said == *"undefined reference to \`palpate::internal::eigen_max_static_align_bytes_is_32"* ]]
fi

# Every installed header compiles after those before it in the alphabet, and after those behind it; none brings another library's headers
# but Eigen's and fmt's. That of the contract of devices is for GoogleTest.
headers=$(cd "$work/prefix/include" && find palpate -name '*.h' ! -name device_contract.h | sort)
if grep -rlE '#include <(nlohmann|boost|CLI|toml|hwy|tbb|kdl|urdf|nanoflann)' "$work/prefix/include/palpate"; then exit 1; fi
for order in sort 'sort -r'; do
  $order <<<"$headers" | sed 's/.*/#include <&>/' >"$work/all.cpp"
  g++ -std=c++20 -Wall -Wextra -Werror -fsyntax-only -DEIGEN_MAX_ALIGN_BYTES=16 -I"$work/prefix/include" -isystem /usr/include/eigen3 "$work/all.cpp"
done

# The man page and the completion scripts are there, as the program prints them.
cmp "$work/prefix/share/man/man1/palpate.1" <("$work/prefix/bin/palpate" man-page)
cmp "$work/prefix/share/bash-completion/completions/palpate" <("$work/prefix/bin/palpate" completion bash)
bash -n "$work/prefix/share/bash-completion/completions/palpate"
