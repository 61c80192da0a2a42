#!/bin/sh
# Builds what is missing, checks the format and the locks of what changed (check.sh) and runs every
# test. Arguments go to ctest. Tests of recorded sequences look for them in CORBSLAM_DATA_DIR and are
# skipped without it; so are the checks without their tools, but not under continuous integration.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
"$root/deploy/build.sh" -DCORBSLAM_BUILD_TESTS=ON -DCORBSLAM_BUILD_BENCHMARKS=ON
failed=0
checked=0
"$root/tests/check.sh" --changed --only format,threads || checked=$?
case $checked in
  0) ;;
  2) [ -z "${CI:-}" ] || failed=1 ;;
  77) ;;
  *) failed=1 ;;
esac
ctest --test-dir "$root/build/release" --output-on-failure -j "$(nproc)" "$@" || failed=1
exit $failed
