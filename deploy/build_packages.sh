#!/bin/sh
# build_packages.sh [FOLDER]: installs what the build needs, builds the programs in build/packages, and
# puts their Debian packages into the folder, or into out/packages.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:-$root/out/packages}
mkdir -p "$out"
out=$(cd "$out" && pwd)
build=$root/build/packages

"$root/deploy/install_packages.sh" packages_debian.txt
cd "$root"
cmake --preset release -B "$build" -DCORBSLAM_BUILD_TESTS=OFF -DCORBSLAM_BUILD_BENCHMARKS=OFF
cmake --build "$build" --target installed
rm -f "$out"/corbslam-*.deb
# cpack leaves what it packed beside the packages.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$work" && cpack -G DEB --config "$build/CPackConfig.cmake")
mv "$work"/corbslam-*.deb "$out"
