#!/bin/sh
# The experiments of the CORB-SLAM paper on simulated streets along the true paths of KITTI's
# sequences 00 (two robots) and 05 (three robots), beside one robot over the whole, and with robots
# that see the same streets in other pictures. Needs a release build and CORBSLAM_DATA_DIR.
#
#   tests/accuracy/paper_experiments.sh [OUT [EXPERIMENT...]]
#
# EXPERIMENT: one_00 two_00 two_00_other one_05 three_05 three_05_other; all without. A run whose
# report is there already is not repeated. Tables go to OUT/paper.md, pictures to OUT/*/map.png.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-$root/out/paper}
[ $# -gt 0 ] && shift
truth=${CORBSLAM_DATA_DIR:?must name the folder that holds kitti_ground_truth}/kitti_ground_truth
bin=${CORBSLAM_BIN:-$root/build/release/bin}
experiments=${*:-one_00 two_00 two_00_other one_05 three_05 three_05_other}

# The rig differs a little from its calibration, as real ones do.
rig='scale_error=0.003&disparity_error_px=0.08&epipolar_error_px=0.15'

street() {  # SEQUENCE [OPTIONS]
  printf 'sim:path?poses=%s/%s.txt&moving_cars=6&%s%s' "$truth" "$1" "$rig" "${2:-}"
}

run() {  # NAME ARGUMENTS...
  name=$1
  shift
  if [ ! -f "$out/$name/report.json" ]; then
    "$bin/corbslam" run --pace max --out "$out/$name" "$@"
  fi
}

for experiment in $experiments; do
  case $experiment in
    one_00) run one_00 --robots 1 --source "$(street 00 '&threads=2')" ;;
    two_00) run two_00 --robots 2 --overlap 20 --source "$(street 00)" ;;
    # The second robot: half a frame later on the way, darker, other noise.
    two_00_other)
      run two_00_other --source "$(street 00 '&robot=1/2')" \
        --source "$(street 00 '&robot=2/2&phase=0.5&exposure=0.75&noise_seed=2')" ;;
    one_05) run one_05 --robots 1 --source "$(street 05 '&threads=2')" ;;
    three_05) run three_05 --robots 3 --overlap 20 --source "$(street 05)" ;;
    # The third one backwards through its part, too.
    three_05_other)
      run three_05_other --source "$(street 05 '&robot=1/3')" \
        --source "$(street 05 '&robot=2/3&phase=0.5&exposure=0.75&noise_seed=2')" \
        --source "$(street 05 '&robot=3/3&reverse=1&exposure_drift=0.2&noise_seed=3')" ;;
    *)
      echo "no experiment $experiment" >&2
      exit 2 ;;
  esac
done

set --
for experiment in one_00 two_00 two_00_other one_05 three_05 three_05_other; do
  report=$out/$experiment/report.json
  [ -f "$report" ] && set -- "$@" "$experiment=$report"
done
"$bin/paper_tables" "$out/paper.md" "$@"
