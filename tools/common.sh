# shellcheck shell=bash disable=SC2034,SC2154 # the scripts that source this use what it sets, and set root
# Functions shared by ./run, ./test and tools/: package installation, builds, generated parts of pages. To be sourced.

build_packages=(g++ cmake ninja-build libeigen3-dev libfmt-dev libnanoflann-dev libtbb-dev libhwy-dev libxxhash-dev
  libboost-dev libssl-dev libcli11-dev nlohmann-json3-dev libtomlplusplus-dev liborocos-kdl-dev liburdfdom-dev
  libconsole-bridge-dev)

say() { printf '\033[1m==> %s\033[0m\n' "$*" >&2; }
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# ensure_packages PACKAGE...: installs missing Debian packages.
ensure_packages() {
  command -v dpkg-query >/dev/null || die "needs Debian 12 or a relative of it; elsewhere install by hand: $*"
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [[ ${#missing[@]} -eq 0 ]] && return
  say "installing ${missing[*]}"
  local as_root=()
  if [[ $(id -u) -ne 0 ]]; then
    command -v sudo >/dev/null || die "is not root and there is no sudo; as root: apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  export DEBIAN_FRONTEND=noninteractive
  # Logged to a file, which is shown only on failure.
  local log
  log=$(mktemp)
  if ! "${as_root[@]}" apt-get update >"$log" 2>&1 ||
    ! "${as_root[@]}" apt-get install -y --no-install-recommends "${missing[@]}" >>"$log" 2>&1; then
    tail -n 20 "$log" >&2
    die "could not install ${missing[*]}; the log is $log"
  fi
  rm -f "$log"
}

# ensure_npm: installs Debian's npm unless there is one of any origin.
ensure_npm() { command -v npm >/dev/null || ensure_packages npm; }

# CMake takes this over when it configures a new folder.
if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}; fi

# For a full build: each library and program is compiled as one source, in a third of the time.
unity=(-DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0)

# build_preset PRESET TESTS [TARGET...]: configures the build folder if necessary, and builds the targets or everything.
# TESTS is ON or OFF; a folder with ON keeps it. A folder whose configuration missed an optional library is configured
# again. A new folder is for full builds; one that was configured by hand compiles each source by itself.
build_preset() {
  local preset=$1 tests=$2 cache=$root/build/$1/CMakeCache.txt
  if [[ ! -e $root/build/$preset/build.ninja ]] ||
    { [[ $tests == ON ]] && ! grep -q '^PALPATE_TESTS:BOOL=ON' "$cache"; } ||
    { [[ $tests == ON ]] && grep -qE '^(MUJOCO_|roscpp_DIR|ROS1_|CYCLONEDDS_).*-NOTFOUND' "$cache"; }; then
    say "configuring build/$preset"
    local joined=()
    [[ -e $cache ]] || joined=("${unity[@]}")
    (cd "$root" && cmake --preset "$preset" "-DPALPATE_TESTS=$tests" "${joined[@]}" >/dev/null)
  fi
  shift 2
  say "building build/$preset (${*:-all})"
  cmake --build "$root/build/$preset" --target "${@:-all}" >&2
}

# Marker lines around the generated part of a page.
begin_mark="<!-- written by tools/$(basename "$0"): begin -->"
end_mark="<!-- written by tools/$(basename "$0"): end -->"

# check_marks PAGE: fails unless the page has each marker line once.
check_marks() {
  local mark
  for mark in "$begin_mark" "$end_mark"; do
    [[ $(grep -cxF "$mark" "$1") -eq 1 ]] || die "$1 has not one line '$mark'"
  done
}

# write_between_marks PAGE FILE: replaces the generated part of the page by the content of FILE.
write_between_marks() {
  local page=$1 text
  text=$(awk -v begin="$begin_mark" -v end="$end_mark" -v part="$2" '
    $0 == end { print ""; inside = 0 }
    !inside { print }
    $0 == begin { inside = 1; print ""; while ((getline line < part) > 0) print line }' "$page")
  printf '%s\n' "$text" >"$page"
  say "wrote $page"
}

# processor: prints the model name of the processor.
processor() { sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1; }
