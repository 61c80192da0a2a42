# Sourced by the scripts beside it, which set `root` and `out`: where programs and recordings are,
# and simulated streets drawn as files.

recordings=${CORBSLAM_DATA_DIR:?must name the folder of the recorded sequences}
truth=$recordings/kitti_ground_truth
bin=${CORBSLAM_BIN:-$root/build/release/bin}
pictures="kitti:$out/pictures"

# The rig differs a little from its calibration, as real ones do. RIG= is one that does not (into an
# --out of its own: what is drawn stays).
rig=${RIG-'scale_error=0.003&disparity_error_px=0.08&epipolar_error_px=0.15'}
# Another robot: half a frame later on the way, darker, other noise.
other='&phase=0.5&exposure=0.75&noise_seed=2'

# Pictures in $out/pictures/NAME, so that the robots' times and memory are their own. What is there
# is not drawn again.
draw() {  # NAME SOURCE
  if [ ! -d "$out/pictures/$1" ]; then
    rm -rf "$out/pictures/$1.part"
    "$bin/corbslam" simulate --layout kitti --threads "$(nproc)" --out "$out/pictures/$1.part" \
      --source "$2"
    mv "$out/pictures/$1.part" "$out/pictures/$1"
  fi
}

# Along the true path of a KITTI sequence.
draw_street() {  # NAME SEQUENCE [OPTIONS]
  draw "$1" "sim:path?poses=$truth/$2.txt&moving_cars=6${rig:+&}$rig${3:-}"
}
