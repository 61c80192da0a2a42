#!/bin/sh
# Builds the programs of a run (deploy/build.sh builds the others, too), then lets two robots drive round
# a block of a simulated town and fuses what they made. Results go to the folder named by the first
# argument, or to out/demo. The second one names another sequence, of which each robot plays a half, for
# example tum:tests/data/tum_fr1_xyz (a recorded one).
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:-$root/out/demo}
export CORBSLAM_TARGETS="map_store fusion_worker client_agent simulated_agent corbslam viewer_page"
"$root/deploy/build.sh" -DCORBSLAM_BUILD_TESTS=OFF -DCORBSLAM_BUILD_BENCHMARKS=OFF
exec "$root/build/release/bin/corbslam" demo --company ${2:+--source "$2"} --out "$out"
