#!/usr/bin/env bash
# Builds the reference of the C++ library in build/docs/html from the comments of its headers. Warnings are errors.
#   tools/docs.sh
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"

ensure_packages doxygen
mkdir -p "$root/build/docs"
cd "$root"
doxygen docs/Doxyfile
say "reference: $root/build/docs/html/index.html"
