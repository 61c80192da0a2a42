#!/bin/bash
# installed_test.sh BUILD: installs what others build with into a folder, looks into it, builds the
# examples against it, and has them push to a robot and follow it.
set -euo pipefail

build=$(cd "$1" && pwd)
work=$(mktemp -d)
robot=
trap '[ -z "$robot" ] || kill "$robot" 2>/dev/null || true; rm -rf "$work"' EXIT

fail() {
  echo "$*" >&2
  [ ! -f "$work/robot.log" ] || tail -20 "$work/robot.log" >&2
  exit 1
}

# start ARGUMENTS...: a robot that plays push:.
start() {
  "$build/bin/client_agent" --source "push:$work/camera.sock" --listen 127.0.0.1:0 --listen-insecure \
    --seed 1 "$@" > "$work/robot.out" 2> "$work/robot.log" &
  robot=$!
}

# stop: it ends as robots do, and writes what it was asked to.
stop() {
  kill -TERM "$robot"
  wait "$robot" || fail "the robot ended with $?"
  robot=
}

for part in push dev; do
  cmake --install "$build" --component $part --prefix "$work/tree" > "$work/install.log" ||
    fail "no installation of $part: $(cat "$work/install.log")"
done
library=$(echo "$work"/tree/lib*/libcorbslam_push.so.0)
[ -f "$library" ] || fail "there is no libcorbslam_push.so.0"
if ! grep -q "CORBSLAM_SANITIZE:STRING=..*" "$build/CMakeCache.txt"; then
  needed=$(readelf -d "$library" | sed -n 's/.*NEEDED.*\[\(.*\)\]/\1/p')
  [ "$needed" = libc.so.6 ] || fail "libcorbslam_push.so.0 needs $needed"
fi
readelf -d "$library" | grep -q 'SONAME.*\[libcorbslam_push.so.0\]' || fail "it has no SONAME"
strange=$(nm -D --defined-only "$library" | awk '$3 !~ /^corbslam_push_/ {print $3}')
[ -z "$strange" ] || fail "it exports $strange"
if command -v cc >/dev/null; then
  echo '#include <corbslam/push.h>' > "$work/header.c"
  cc -std=c99 -pedantic -Wall -Wextra -Werror -fsyntax-only -I"$work/tree/include" "$work/header.c" ||
    fail "corbslam/push.h is no C"
fi

cmake -S "$work/tree/share/doc/corbslam-dev/examples" -B "$work/examples" -DWITH_API=ON \
  -DCMAKE_PREFIX_PATH="$work/tree" > "$work/configure.log" 2>&1 || fail "$(cat "$work/configure.log")"
cmake --build "$work/examples" > "$work/build.log" 2>&1 || fail "$(cat "$work/build.log")"

# C++: the robot learns the rig from the driver.
start --trajectory "$work/wall.tum"
"$work/examples/push_wall" "$work/camera.sock" 30 > "$work/wall.out" &
wall=$!
for _ in $(seq 300); do
  grep -q "listening on" "$work/robot.out" && break
  sleep 0.1
done
address=$(sed -n 's/listening on //p' "$work/robot.out")
timeout 60 "$work/examples/follow_poses" "$address" 3 > "$work/follow.out" || fail "no poses over gRPC"
wait $wall || fail "push_wall ended with $?"
stop
[ "$(grep -c ' at ' "$work/wall.out")" -ge 10 ] || fail "push_wall heard $(cat "$work/wall.out")"
[ "$(grep -c STATE_TRACKING "$work/follow.out")" -ge 1 ] || fail "follow_poses heard $(cat "$work/follow.out")"
[ "$(wc -l < "$work/wall.tum")" -ge 10 ] || fail "the robot's trajectory has $(cat "$work/wall.tum")"
# 2 cm a frame to the right: the last pose is where 30 frames lead, give or take two that were dropped.
tail -1 "$work/wall.out" | awk '{exit !($3 > 0.5 && $3 < 0.62 && $4^2 + $5^2 < 0.01)}' ||
  fail "the wall's last pose is $(tail -1 "$work/wall.out")"

# Python: a folder as KITTI's, of the same wall; the rig is the robot's.
python3 - "$work/folder" "$work/rig.yaml" <<'PYTHON'
import pathlib, random, sys
folder, rig = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
random.seed(1)
tiles = [[random.randrange(256) for _ in range(200)] for _ in range(45)]
wall = [bytes(grey for grey in row for _ in range(8)) for row in tiles for _ in range(8)]
for name, shift in [("image_0", 0), ("image_1", 20)]:
    (folder / name).mkdir(parents=True)
    for i in range(20):
        left = 100 + 4 * i + shift
        (folder / name / f"{i:06d}.pgm").write_bytes(
            b"P5\n640 360\n255\n" + b"".join(row[left:left + 640] for row in wall))
(folder / "times.txt").write_text("".join(f"{0.1 * i}\n" for i in range(20)))
camera = "{size_px: [640, 360], focal_px: [400, 400], principal_px: [320, 180]}"
rig.write_text(f"rig: 1\nkind: stereo\ncameras:\n  - {camera}\n  - {camera}\n"
               "rectified: true\nbaseline_m: 0.1\n")
PYTHON
start --rig "$work/rig.yaml"
python3 -B "$work/tree/share/doc/corbslam-dev/examples/push_folder.py" "$work/folder" "$work/camera.sock" \
  --stamps recorded --poses "$work/poses.tum" --library "$library" || fail "push_folder.py ended with $?"
stop
[ "$(wc -l < "$work/poses.tum")" -ge 10 ] || fail "push_folder.py heard $(cat "$work/poses.tum")"
