#!/usr/bin/env bash
# Cross-compiles the tests of base, scene, collision and haptics for aarch64, in build/aarch64, and runs them under
# qemu-user: with all instructions of the emulated processor, and what depends on it without AES instructions (as on a
# Raspberry Pi 4), too.
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -eq 0 ]] || die "usage: tools/aarch64.sh"

ensure_packages cmake ninja-build g++-aarch64-linux-gnu qemu-user-static
build=$root/build/aarch64
sysroot=$build/sysroot
apt=$build/apt
jobs=$(nproc)

# apt-get for the arm64 packages, which are unpacked into the sysroot and not installed.
apt_arm64() {
  apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User=root \
    -o "Dir::State=$apt/state" -o "Dir::State::status=$apt/status" -o "Dir::Cache=$apt/cache" "$@"
}
if [[ ! -e $sysroot/ready ]]; then
  say "unpacking the libraries for aarch64"
  rm -rf "$apt" "$sysroot"
  mkdir -p "$apt/state/lists/partial" "$apt/cache/archives/partial" "$sysroot"
  : >"$apt/status"
  apt_arm64 update
  # The libraries among build_packages.
  mapfile -t libraries < <(printf '%s\n' "${build_packages[@]}" libgtest-dev libgmock-dev libc6-dev | grep -- '-dev$')
  apt_arm64 install -y --download-only --no-install-recommends "${libraries[@]}" >/dev/null
  for package in "$apt"/cache/archives/*.deb; do dpkg-deb -x "$package" "$sysroot"; done
  # The CMake config of urdfdom names a library by its installed path.
  sed -i "s|/usr/lib/[a-z0-9-]*/libtinyxml.so|$sysroot&|" "$sysroot"/usr/lib/*/urdfdom/cmake/urdfdomExport.cmake
  touch "$sysroot/ready"
fi

say "building build/aarch64"
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_TOOLCHAIN_FILE=$root/cmake/aarch64.cmake" \
  "-DAARCH64_SYSROOT=$sysroot" -DPALPATE_APPS=OFF -DPALPATE_TESTS=ON "${unity[@]}" >/dev/null
cmake --build "$build" --target test_base test_scene test_collision test_haptics >&2

# Library to preload that hides the AES instructions from getauxval().
cat >"$build/no_aes.c" <<'EOF'
#define _GNU_SOURCE
#include <asm/hwcap.h>
#include <dlfcn.h>
#include <sys/auxv.h>

unsigned long getauxval(unsigned long type) {
  unsigned long (*const ask)(unsigned long) = (unsigned long (*)(unsigned long))dlsym(RTLD_NEXT, "getauxval");
  return type == AT_HWCAP ? ask(type) & ~(unsigned long)HWCAP_AES : ask(type);
}
EOF
aarch64-linux-gnu-gcc "--sysroot=$sysroot" -O2 -shared -fPIC -o "$build/no_aes.so" "$build/no_aes.c"

for processor in "with AES" "without AES"; do
  preload=()
  [[ $processor == "with AES" ]] || preload=(-E "LD_PRELOAD=$build/no_aes.so")
  for test in base scene collision haptics; do
    say "test_$test on aarch64, $processor"
    # What haptics has, or tests, that is compiled for each processor.
    only='*'
    [[ $processor == "with AES" || $test != haptics ]] || only='DepthView*:SplatTracker*:SelectSplats*'
    parts=()
    for ((part = 0; part < jobs; ++part)); do
      (cd "$build" && GTEST_TOTAL_SHARDS=$jobs GTEST_SHARD_INDEX=$part \
        qemu-aarch64-static "${preload[@]}" -L "$sysroot" "bin/test_$test" --gtest_brief=1 "--gtest_filter=$only") &
      parts+=($!)
    done
    for part in "${parts[@]}"; do wait "$part"; done
  done
done
