#!/bin/sh
# Builds what is missing, then lets two robots map the halves of a recorded sequence and fuses
# what they made. Results go to the folder named by the first argument, or to out/demo.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:-$root/out/demo}
"$root/deploy/build.sh" -DCORBSLAM_BUILD_TESTS=OFF -DCORBSLAM_BUILD_BENCHMARKS=OFF
"$root/build/release/bin/corbslam" run --source "tum:$root/tests/data/tum_fr1_xyz" \
  --robots 2 --overlap 20 --out "$out"
echo
cat "$out/report.md"
echo
echo "the map: $out/map.png"
