#!/usr/bin/env bash
# Makes the Debian packages palpate, palpate-ros and libpalpate-dev in build/packages, and checks them with lintian;
# fails on errors and warnings.
#   tools/packages.sh
# DEBFULLNAME and DEBEMAIL set the maintainer.
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"
[[ $# -eq 0 ]] || die "usage: tools/packages.sh"

ensure_packages "${build_packages[@]}" dpkg-dev lintian man-db libmujoco-dev libroscpp-dev lib{geometry,diagnostic,sensor,tf2,visualization}-msgs-dev \
  libstd-srvs-dev cyclonedds-dev cyclonedds-tools
ensure_npm

# Reproducible builds: the same commit gives identical packages.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git -C "$root" log -1 --format=%ct 2>/dev/null || date +%s)}
export SOURCE_DATE_EPOCH
# Configured again to find libraries that were just installed.
[[ ! -e $root/build/release/build.ninja ]] || cmake "$root/build/release" >/dev/null
build_preset release OFF palpate_cli {device,palpate}_ros{1,2}

packages=$root/build/packages
rm -rf "$packages"
say "packing"
cpack --config "$root/build/release/CPackConfig.cmake" -B "$packages" >"$root/build/packages.log" ||
  die "cpack failed; see $root/build/packages.log"
rm -rf "$packages/_CPack_Packages"
# Without --allow-root, lintian warns when run as root.
lintian --allow-root --fail-on error,warning "$packages"/*.deb
say "packages:"
du -h "$packages"/*.deb
