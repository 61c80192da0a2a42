#!/bin/sh
# Installs what is missing and builds the release into build/release: everything, or the targets that
# CORBSLAM_TARGETS names. Arguments go to cmake.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
"$root/deploy/install_packages.sh"
cd "$root"
cmake --preset release "$@"
# shellcheck disable=SC2086
cmake --build --preset release ${CORBSLAM_TARGETS:+--target $CORBSLAM_TARGETS}
