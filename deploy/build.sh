#!/bin/sh
# Installs what is missing and builds the release into build/release. Arguments go to cmake.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
"$root/deploy/install_packages.sh"
cd "$root"
cmake --preset release "$@"
cmake --build --preset release
