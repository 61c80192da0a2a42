#!/bin/sh
# Every split of recorded and simulated sequences among several robots, several times, beside one
# robot over the whole: is the fused map as good? Needs a release build and CORBSLAM_DATA_DIR.
#
#   tests/accuracy/splits.sh [--out DIR] [--runs N] [--only NAME]... [--list]
#
# Each run is one of real programs at full pace (PACE: `corbslam run`'s), so no two are the same. A
# run whose report is in DIR (out/splits) is not made again: stop it whenever you like, and go on
# later. --only takes names of splits, or of one robot's runs (--list). The table goes to
# DIR/splits.md and DIR/splits.json. Exit status 1: a bar is missed by splits that are complete.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
out=$root/out/splits
runs=5
only=
pace=${PACE:-max}

# NAME:REFERENCE, the reference being one robot over the whole sequence.
recorded='kitti_two:kitti_one kitti_three:kitti_one kitti_interleaved:kitti_one
  tum_two:tum_one tum_three:tum_one tum_backwards:tum_one lab_two:lab_one'
simulated='floor_two:floor_one city_two:city_one city_three:city_one
  05_three:05_one 05_three_other:05_one 00_two:00_one 00_two_other:00_one'
splits="$recorded $simulated"

while [ $# -gt 0 ]; do
  case $1 in
    --out) out=$2; shift 2 ;;
    --runs) runs=$2; shift 2 ;;
    --only) only="$only $2"; shift 2 ;;
    --list) echo "$splits" | tr -s ' \n' '\n\n'; exit 0 ;;
    *) sed -n '2,10s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
done

. "$root/tests/accuracy/streets.sh"

kitti="kitti:$recordings/kitti_00_first201"
tum="tum:$recordings/tum_fr1_xyz_15hz"
lab="tum:$root/tests/data/tum_fr1_xyz"
floor='sim:floor?seed=2&picture_scale=0.6&frames=:300'

run() {  # NAME ARGUMENTS...
  name=$1
  shift
  number=1
  while [ "$number" -le "$runs" ]; do
    if [ ! -f "$out/$name/$number/report.json" ]; then
      "$bin/corbslam" run --pace "$pace" --out "$out/$name/$number" "$@"
    fi
    number=$((number + 1))
  done
}

run_named() {  # NAME
  case $1 in
    kitti_one) run "$1" --source "$kitti" --robots 1 ;;
    kitti_two) run "$1" --source "$kitti" --robots 2 ;;
    kitti_three) run "$1" --source "$kitti" --robots 3 ;;
    kitti_interleaved)
      run "$1" --source "$kitti" --robots 2 --split interleaved --perturb 2:gamma=0.8,noise=4 ;;
    tum_one) run "$1" --source "$tum" --robots 1 ;;
    tum_two) run "$1" --source "$tum" --robots 2 ;;
    tum_three) run "$1" --source "$tum" --robots 3 ;;
    tum_backwards) run "$1" --source "$tum" --robots 2 --perturb 2:reverse ;;
    lab_one) run "$1" --source "$lab" --robots 1 ;;
    lab_two) run "$1" --source "$lab" --robots 2 ;;
    floor_one) run "$1" --source "$floor" --robots 1 ;;
    floor_two) run "$1" --source "$floor" --robots 2 ;;
    city_*)
      draw city 'sim:city?seed=7&length=400'
      run_city "$1" ;;
    00_*)
      draw_street 00 00
      run_00 "$1" ;;
    05_*)
      draw_street 05 05
      run_05 "$1" ;;
    *)
      echo "no split $1" >&2
      exit 2 ;;
  esac
}

run_city() {  # NAME
  case $1 in
    city_one) run "$1" --source "$pictures/city" --robots 1 ;;
    city_two) run "$1" --source "$pictures/city" --robots 2 ;;
    city_three) run "$1" --source "$pictures/city" --robots 3 ;;
  esac
}

run_00() {  # NAME
  case $1 in
    00_one) run "$1" --source "$pictures/00" --robots 1 ;;
    00_two) run "$1" --source "$pictures/00" --robots 2 ;;
    00_two_other)
      draw_street 00_second 00 "&robot=2/2$other"
      run "$1" --source "$pictures/00?robot=1/2&truth_frame=00" \
        --source "$pictures/00_second?truth_frame=00" ;;
  esac
}

run_05() {  # NAME
  case $1 in
    05_one) run "$1" --source "$pictures/05" --robots 1 ;;
    05_three) run "$1" --source "$pictures/05" --robots 3 ;;
    # The third one backwards through its part.
    05_three_other)
      draw_street 05_second 05 "&robot=2/3$other"
      draw_street 05_third 05 '&robot=3/3&exposure_drift=0.2&noise_seed=3'
      run "$1" --source "$pictures/05?robot=1/3&truth_frame=05" \
        --source "$pictures/05_second?truth_frame=05" \
        --source "$pictures/05_third?reverse=1&truth_frame=05" ;;
  esac
}

if [ -z "$only" ]; then
  for split in $splits; do only="$only ${split#*:} ${split%:*}"; done
fi
for name in $only; do run_named "$name"; done
# Words on purpose.
# shellcheck disable=SC2086
"$bin/split_table" --folder "$out" --runs "$runs" $splits
