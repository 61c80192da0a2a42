#!/bin/sh
# lenses.sh [RUNS [FRAMES]]: one simulated drive through four pairs of cameras, each alone and RUNS
# times: a rectified pinhole pair, a pair of radial-tangential lenses that is not rectified, and
# fisheyes of 150 and 190 degrees, those at several widths of the rectified pinhole. Prints ATE
# (least, median, most) and frames tracked for each. CORBSLAM_BIN: where the programs are;
# CORBSLAM_OUT: where pictures and results go; what is drawn there is not drawn again.
set -eu

runs=${1:-5}
frames=${2:-300}
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=${CORBSLAM_BIN:-$root/build/release/bin}
out=${CORBSLAM_OUT:-$root/build/lenses}
drive="sim:city?seed=7&length=400&frames=0:$((frames - 1))"
mkdir -p "$out"

# The right camera is turned by about two degrees; the baseline is KITTI's.
turned='right_from_left: [0.9993908, -0.0348995, 0, -0.537,
                  0.0348782, 0.9987816, -0.0348995, 0,
                  0.0012180, 0.0348782, 0.9993908, 0,
                  0, 0, 0, 1]'

rig() {  # NAME LENS NUMBERS FOCAL [WIDEST]
  cat >"$out/$1.yaml" <<RIG
rig: 1
kind: stereo
rate_hz: 10
cameras:
  - {size_px: [960, 600], focal_px: [$4, $4], principal_px: [481, 298], lens: $2, lens_numbers: $3}
  - {size_px: [960, 600], focal_px: [$4, $4], principal_px: [476, 303], lens: $2, lens_numbers: $3}
rectified: false
$turned
${5:+widest_field_deg: $5}
RIG
}

cat >"$out/pinhole.yaml" <<'RIG'
rig: 1
kind: stereo
rate_hz: 10
rectified: true
baseline_m: 0.537
cameras:
  - {size_px: [960, 600], focal_px: [480, 480], principal_px: [480, 300]}
  - {size_px: [960, 600], focal_px: [480, 480], principal_px: [480, 300]}
RIG
rig radial radial-tangential '[-0.2, 0.04, 0.0002, -0.0001]' 520
rig fisheye150 equidistant '[0.003, -0.002, 0.001, 0]' 366
rig fisheye190 equidistant '[0.003, -0.002, 0.001, 0]' 290
for lens in 150:366 190:290; do
  for widest in 90 110 130; do
    rig "fisheye${lens%:*}_$widest" equidistant '[0.003, -0.002, 0.001, 0]' "${lens#*:}" "$widest"
  done
done

measure() {  # PICTURES RIG
  folder=$out/pictures/$1
  if [ ! -d "$folder" ]; then
    rm -rf "$folder.part"
    "$bin/corbslam" simulate --source "$drive" --rig "$out/$1.yaml" --layout kitti --out "$folder.part"
    mv "$folder.part" "$folder"
  fi
  for run in $(seq "$runs"); do
    "$bin/corbslam" run --pace max --robots 1 --out "$out/$2_$run" \
      --source "kitti:$folder?rig=$out/$2.yaml" >"$out/$2_$run.log" 2>&1
    echo "$out/$2_$run/report.json"
  done | python3 -c '
import json, sys
reports = [json.load(open(line.strip()))["robots"][0] for line in sys.stdin]
ates = sorted(report["ate_m"] for report in reports)
print("| %s | %.4f (%.4f to %.4f) | %s of %d |" % (
    sys.argv[1], ates[len(ates) // 2], ates[0], ates[-1],
    ", ".join(sorted({str(report["tracked"]) for report in reports})), reports[0]["frames"]))' "$2"
}

echo "| pictures | ATE, m: median (least to most) | frames tracked |"
echo "| --- | --- | --- |"
measure pinhole pinhole
measure radial radial
for widest in 90 110 130; do
  measure fisheye150 "fisheye150_$widest"
  measure fisheye190 "fisheye190_$widest"
done
