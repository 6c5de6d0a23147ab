#!/usr/bin/env bash
# Takes the pictures of the viewer in docs/images from the program as it is now. It takes some minutes.
#   tools/viewer_pictures.sh
set -euo pipefail
root=$(dirname "$(dirname "$(realpath "$0")")")
# shellcheck source=tools/common.sh
source "$root/tools/common.sh"

ensure_packages "${build_packages[@]}" chromium
ensure_npm
build_preset release OFF palpate_cli
PALPATE_BINARY=$root/build/release/bin/palpate
export PALPATE_BINARY
# shellcheck source=tests/web/packages.sh
source "$root/tests/web/packages.sh"
enter "$root/build/pictures" "$root/tests/web/viewer"
node pictures.mjs "$root/docs/images"
say "pictures: $root/docs/images/viewer-{contact,phone,vr}.png"
