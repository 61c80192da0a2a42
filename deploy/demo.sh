#!/bin/sh
# Builds what is missing, then lets two robots map the halves of a drive through a simulated town
# and fuses what they made. Results go to the folder named by the first argument, or to out/demo.
# The second one names another sequence, for example tum:tests/data/tum_fr1_xyz (a recorded one).
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:-$root/out/demo}
source=${2:-sim:city?seed=7&length=400}
"$root/deploy/build.sh" -DCORBSLAM_BUILD_TESTS=OFF -DCORBSLAM_BUILD_BENCHMARKS=OFF
exec "$root/build/release/bin/corbslam" demo --source "$source" --out "$out"
