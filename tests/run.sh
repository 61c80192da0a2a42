#!/bin/sh
# Builds what is missing and runs every test. Arguments go to ctest. Tests of recorded sequences
# look for them in CORBSLAM_DATA_DIR and are skipped without it.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
"$root/deploy/build.sh" -DCORBSLAM_BUILD_TESTS=ON -DCORBSLAM_BUILD_BENCHMARKS=ON
ctest --test-dir "$root/build/release" --output-on-failure -j "$(nproc)" "$@"
