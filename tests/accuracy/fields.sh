#!/bin/sh
# fields.sh [RUNS [FRAMES]]: how wide a pinhole should fisheyes be rectified to (widest_field_deg of
# the rig)? Simulated drives of a pair of 190-degree equidistant lenses, three in streets and three
# indoors, each played RUNS times at each width by one robot alone. Prints ATE (median, least, most),
# the ratio to that of 90 degrees, milliseconds a frame and frames lost. CORBSLAM_BIN: where the
# programs are; CORBSLAM_OUT: where pictures and results go; what is drawn there is not drawn again.
# FIELDS and DRIVES choose others: a drive is city, walk or flight and its seed.
set -eu

runs=${1:-5}
frames=${2:-250}
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=${CORBSLAM_BIN:-$root/build/release/bin}
out=${CORBSLAM_OUT:-$root/build/fields}
fields=${FIELDS:-80 90 100 110 120}
drives=${DRIVES:-city_3 city_7 city_11 walk_2 walk_8 flight_5}
mkdir -p "$out/pictures"

source_of() {  # DRIVE
  case $1 in
    city_*) echo "sim:city?seed=${1#city_}&length=400" ;;
    walk_*) echo "sim:floor?seed=${1#walk_}" ;;
    flight_*) echo "sim:floor?seed=${1#flight_}&motion=fly" ;;
    *) echo "no such drive: $1" >&2; exit 2 ;;
  esac
}

# The right camera is turned by about two degrees. Streets have KITTI's baseline and rate; indoors
# they are what fits a walker.
rig() {  # DRIVE WIDEST
  case $1 in
    city_*) baseline=0.537 rate=10 ;;
    *) baseline=0.12 rate=15 ;;
  esac
  lens='lens: equidistant, lens_numbers: [0.003, -0.002, 0.001, 0]'
  cat >"$out/$1_$2.yaml" <<RIG
rig: 1
kind: stereo
rate_hz: $rate
cameras:
  - {size_px: [960, 600], focal_px: [290, 290], principal_px: [481, 298], $lens}
  - {size_px: [960, 600], focal_px: [290, 290], principal_px: [476, 303], $lens}
rectified: false
right_from_left: [0.9993908, -0.0348995, 0, -$baseline,
                  0.0348782, 0.9987816, -0.0348995, 0,
                  0.0012180, 0.0348782, 0.9993908, 0,
                  0, 0, 0, 1]
widest_field_deg: $2
RIG
}

draw() {  # DRIVE
  folder=$out/pictures/$1
  [ ! -d "$folder" ] || return 0
  rm -rf "$folder.part"
  rig "$1" 90
  "$bin/corbslam" simulate --source "$(source_of "$1")&frames=0:$((frames - 1))" \
    --rig "$out/$1_90.yaml" --layout kitti --out "$folder.part" >"$out/$1.log" 2>&1
  mv "$folder.part" "$folder"
}

play() {  # DRIVE WIDEST
  rig "$1" "$2"
  for run in $(seq "$runs"); do
    "$bin/corbslam" run --pace max --robots 1 --out "$out/$1_$2_$run" \
      --source "kitti:$out/pictures/$1?rig=$out/$1_$2.yaml" >"$out/$1_$2_$run.log" 2>&1
  done
}

for drive in $drives; do
  draw "$drive"
  for widest in $fields; do play "$drive" "$widest"; done
done

python3 - "$out" "$runs" "$drives" "$fields" <<'TABLE'
import json, statistics, sys

out, runs, drives, fields = sys.argv[1], int(sys.argv[2]), sys.argv[3].split(), sys.argv[4].split()

def robots(drive, field):
    return [json.load(open(f"{out}/{drive}_{field}_{run}/report.json"))["robots"][0]
            for run in range(1, runs + 1)]

print("| drive | field, degrees | ATE, m: median (least to most) | beside 90 | ms a frame, median | lost, of frames |")
print("| --- | --- | --- | --- | --- | --- |")
for drive in drives:
    measured = {field: robots(drive, field) for field in fields}
    median = {field: statistics.median(r["ate_m"] for r in measured[field]) for field in fields}
    for field in fields:
        ates = [r["ate_m"] for r in measured[field]]
        beside = "%.2f" % (median[field] / median["90"]) if "90" in median else ""
        print("| %s | %s | %.4f (%.4f to %.4f) | %s | %.1f | %s of %d |" % (
            drive, field, median[field], min(ates), max(ates), beside,
            statistics.median(r["tracking_ms"]["median"] for r in measured[field]),
            ", ".join(sorted({str(r["frames"] - r["tracked"]) for r in measured[field]})),
            measured[field][0]["frames"]))
TABLE
