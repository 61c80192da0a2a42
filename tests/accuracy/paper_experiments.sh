#!/bin/sh
# The experiments of the CORB-SLAM paper on simulated streets along the true paths of KITTI's
# sequences 00 (two robots) and 05 (three robots), beside one robot over the whole, and with robots
# that see the same streets in other pictures. Needs a release build and CORBSLAM_DATA_DIR.
#
#   tests/accuracy/paper_experiments.sh [OUT [EXPERIMENT...]]
#
# EXPERIMENT: one_00 two_00 two_00_other one_05 three_05 three_05_other; all without. The pictures
# are drawn first (OUT/pictures, 7 GB in all), so that the robots' times and memory are their own.
# What is there already is not made again. PACE (max) is `corbslam run`'s. Tables go to OUT/paper.md,
# maps to OUT/*/map.png.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-$root/out/paper}
[ $# -gt 0 ] && shift
pace=${PACE:-max}
experiments=${*:-one_00 two_00 two_00_other one_05 three_05 three_05_other}

. "$root/tests/accuracy/streets.sh"

run() {  # NAME ARGUMENTS...
  name=$1
  shift
  if [ ! -f "$out/$name/report.json" ]; then
    "$bin/corbslam" run --pace "$pace" --out "$out/$name" "$@"
  fi
}

for experiment in $experiments; do
  case $experiment in
    one_00)
      draw_street 00 00
      run one_00 --robots 1 --source "$pictures/00" ;;
    two_00)
      draw_street 00 00
      run two_00 --robots 2 --overlap 20 --source "$pictures/00" ;;
    two_00_other)
      draw_street 00 00
      draw_street 00_second 00 "&robot=2/2$other"
      run two_00_other --source "$pictures/00?robot=1/2&truth_frame=00" \
        --source "$pictures/00_second?truth_frame=00" ;;
    one_05)
      draw_street 05 05
      run one_05 --robots 1 --source "$pictures/05" ;;
    three_05)
      draw_street 05 05
      run three_05 --robots 3 --overlap 20 --source "$pictures/05" ;;
    # The third one backwards through its part.
    three_05_other)
      draw_street 05 05
      draw_street 05_second 05 "&robot=2/3$other"
      draw_street 05_third 05 '&robot=3/3&exposure_drift=0.2&noise_seed=3'
      run three_05_other --source "$pictures/05?robot=1/3&truth_frame=05" \
        --source "$pictures/05_second?truth_frame=05" \
        --source "$pictures/05_third?reverse=1&truth_frame=05" ;;
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
