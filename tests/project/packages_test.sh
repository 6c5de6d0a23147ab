#!/usr/bin/env bash
# What is in the Debian packages works: unpacks them, feels a scene with the program, reads its man page, completes a command, and builds a
# consumer of the library.
# usage: packages_test.sh PACKAGES_FOLDER, where tools/packages.sh has made them
set -euo pipefail
packages=$(realpath "${1:?usage: packages_test.sh PACKAGES_FOLDER}")
root=$(realpath "$(dirname "$(realpath "$0")")/../..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
  echo "$*" >&2
  exit 1
}

for package in "$packages"/*.deb; do
  name=$(dpkg -f "$package" Package)
  dpkg --fsys-tarfile "$package" | tar -t | grep -v '/$' >>"$work/files" # folders may be shared
  dpkg -x "$package" "$work/root"
  for document in copyright changelog.gz CHANGELOG.md.gz; do
    [[ -s $work/root/usr/share/doc/$name/$document ]] || fail "$name has no $document"
  done
done
twice=$(sort "$work/files" | uniq -d)
[[ -z $twice ]] || fail "in two packages: $twice"
elsewhere=$(grep -v '^\./usr/' "$work/files" || true)
[[ -z $elsewhere ]] || fail "not below /usr: $elsewhere"
installed=$work/root/usr
export LD_LIBRARY_PATH=$installed/lib # where they are shared
# The program needs what it is linked with; headers and CMake files need the packages that they name, which are those it was built with.
[[ $(dpkg -f "$packages"/palpate_*.deb Depends) == *libtbb12* ]] || fail "palpate does not need oneTBB"
needed=$(dpkg -f "$packages"/libpalpate-dev_*.deb Depends | tr -d , | sed 's/([^)]*)//g')
[[ $needed == *libeigen3-dev* ]] || fail "libpalpate-dev needs: $needed"
for package in $needed; do
  compgen -G "$packages/${package}_*.deb" >/dev/null || dpkg-query -W "$package" >/dev/null || fail "libpalpate-dev needs $package, which is not there"
done

palpate=$installed/bin/palpate
"$palpate" make-scene sphere --out "$work/sphere.ply" -q
answer=$("$palpate" query "$work/sphere.ply" --pose 0,0,0.18 --json)
[[ $answer =~ \"contacts\" ]] || fail "$answer"
# It finds the driver beside it, which finds no master.
if compgen -G "$packages/palpate-ros_*.deb" >/dev/null; then
  said=$(env -u ROS_MASTER_URI "$palpate" run "$work/sphere.ply" --device ros1:/omni --no-gateway --seconds 1 2>&1 </dev/null || true)
  [[ $said == *ROS_MASTER_URI* ]] || fail "--device ros1:/omni says: $said"
fi

# man takes the man pages as they are, and that of the program is what it says itself.
for page in "$installed"/share/man/man1/*.gz; do
  man --warnings -E UTF-8 -l "$page" >/dev/null 2>"$work/warnings"
  [[ ! -s $work/warnings ]] || fail "$page: $(cat "$work/warnings")"
done
cmp <("$palpate" man-page) <(zcat "$installed/share/man/man1/palpate.1.gz")

# bash finds the completion where it is installed.
said=$(bash --norc -c "source '$installed/share/bash-completion/completions/palpate'
  COMP_WORDS=(palpate repl); COMP_CWORD=1; _palpate; printf '%s\n' \"\${COMPREPLY[@]}\"")
[[ $said == replay ]] || fail "completes repl with: $said"
for file in zsh/vendor-completions/_palpate fish/vendor_completions.d/palpate.fish; do
  grep -q replay "$installed/share/$file" || fail "$file does not know replay"
done

# A consumer finds the library.
cmake -S "$root/tests/project/consumer" -B "$work/consumer" -G Ninja "-DCMAKE_PREFIX_PATH=$installed" >/dev/null
cmake --build "$work/consumer" >/dev/null
contacts=$("$work/consumer/consumer" "$work/sphere.ply")
[[ $(wc -l <<<"$contacts") -gt 100 ]] || fail "$contacts"
