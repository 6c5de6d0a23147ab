#!/usr/bin/env bash
# roslib and the reference client against the program. usage: run.sh WORK_FOLDER PALPATE [SCRIPT ARGS...]
set -euo pipefail
work=$(realpath -m "${1:?usage: run.sh WORK_FOLDER PALPATE [SCRIPT ARGS...]}")
PALPATE=$(realpath "${2:?usage: run.sh WORK_FOLDER PALPATE [SCRIPT ARGS...]}")
export PALPATE
here=$(dirname "$(realpath "$0")")
PALPATE_CLIENT=$(realpath "$here/../../../examples/client/palpate_client.mjs")
PALPATE_RELAY=$(realpath "$here/../../network/relay.py")
export PALPATE_CLIENT PALPATE_RELAY
# shellcheck source=tests/web/packages.sh
source "$here/../packages.sh"
enter "$work" "$here"
# roslib wants Node 20; Debian 12 has 18, and npm has the other.
node=(node)
[[ $(node -p 'process.versions.node.split(".")[0]') -ge 20 ]] || node=(npx -y -p node@20 node)
if [[ $# -gt 2 ]]; then
  "${node[@]}" "${@:3}"
else
  "${node[@]}" --test --test-concurrency=3 --test-timeout=300000 gateway_test.mjs client_test.mjs both_clients_test.mjs local_model_test.mjs tls_test.mjs
fi
