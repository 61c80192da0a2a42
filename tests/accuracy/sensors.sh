#!/bin/sh
# sensors.sh [RUNS [FRAMES]]: what imperfect cameras cost one robot. Simulated drives, drawn with a
# rolling shutter that takes 0, 10, 20 and 30 ms, and with depth that is measured from the picture's
# own place, and from 25 and 50 mm aside and registered. Each is played RUNS times. Prints ATE
# (median, least, most), the ratio to the drive's first row and frames lost. CORBSLAM_BIN: where the
# programs are; CORBSLAM_OUT: where pictures and results go; what is drawn there is not drawn again.
# CORBSLAM_DRAWING: a corbslam that draws, where it is another one.
set -eu

runs=${1:-5}
frames=${2:-200}
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=${CORBSLAM_BIN:-$root/build/release/bin}
drawing=${CORBSLAM_DRAWING:-$bin/corbslam}
out=${CORBSLAM_OUT:-$root/build/sensors}
mkdir -p "$out/pictures"

measure() {  # DRIVE LAYOUT SOURCE OPTION VALUE...
  drive=$1 layout=$2 source=$3 option=$4
  shift 4
  for value in "$@"; do
    folder=$out/pictures/${drive}_${option}_$value
    if [ ! -d "$folder" ]; then
      rm -rf "$folder.part"
      "$drawing" simulate --source "$source&frames=0:$((frames - 1))&$option=$value" \
        --layout "$layout" --out "$folder.part" >"$folder.log" 2>&1
      mv "$folder.part" "$folder"
    fi
    for run in $(seq "$runs"); do
      "$bin/corbslam" run --pace max --robots 1 --out "$out/${drive}_${value}_$run" \
        --source "$layout:$folder" >"$out/${drive}_${value}_$run.log" 2>&1
    done
  done
  python3 - "$out" "$runs" "$drive" "$option" "$@" <<'TABLE'
import json, statistics, sys

out, runs, drive, option, values = sys.argv[1], int(sys.argv[2]), *sys.argv[3:5], sys.argv[5:]
first = None
for value in values:
    robots = [json.load(open(f"{out}/{drive}_{value}_{run}/report.json"))["robots"][0]
              for run in range(1, runs + 1)]
    ates = [robot["ate_m"] for robot in robots]
    median = statistics.median(ates)
    first = first or median
    print("| %s | %s=%s | %.4f (%.4f to %.4f) | %.2f | %s of %d | %s |" % (
        drive, option, value, median, min(ates), max(ates), median / first,
        ", ".join(sorted({str(robot["frames"] - robot["tracked"]) for robot in robots})),
        robots[0]["frames"], ", ".join(sorted({str(robot["local_maps"]) for robot in robots}))))
TABLE
}

echo "| drive | sensor | ATE, m: median (least to most) | beside the first | lost, of frames | local maps |"
echo "| --- | --- | --- | --- | --- | --- |"
measure city_7 kitti "sim:city?seed=7&length=400" rolling_shutter_ms 0 10 20 30
measure walk_2 euroc "sim:floor?seed=2&rig=euroc" rolling_shutter_ms 0 10 20 30
measure depth_walk_2 tum "sim:floor?seed=2" depth_aside_m 0 0.025 0.05
measure depth_flight_5 tum "sim:floor?seed=5&motion=fly" depth_aside_m 0 0.025 0.05
