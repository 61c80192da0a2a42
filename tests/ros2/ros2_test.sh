#!/bin/bash
# ros2_test.sh PROGRAMS TESTS FOLDER: corbslam_ros2 against Fast DDS, with messages that Foxglove's packages encode
# and decode: every topic both ways, TF followed by a client of its own, qualities of service that don't match,
# services. 77: node or the packages can't be had here; with CI set that is a failure where node is there.
set -eu

programs=$1
tests=$2
work=$3
here=$(cd "$(dirname "$0")" && pwd)
# Nobody else on this network is to hear it.
export ROS_DOMAIN_ID=$((60 + $$ % 40))

if ! command -v node >/dev/null; then
  echo "skipped: no node"
  exit 77
fi
mkdir -p "$work"
cp "$here/package.json" "$here/package-lock.json" "$here"/*.mjs "$work"
if ! cmp -s "$work/package-lock.json" "$work/node_modules/.fetched"; then
  if ! (cd "$work" && npm ci --ignore-scripts --no-audit --no-fund); then
    echo "npm can't fetch the packages"
    [ -n "${CI:-}" ] || exit 77
    exit 1
  fi
  cp "$work/package-lock.json" "$work/node_modules/.fetched"
fi
cd "$work"
rm -rf city ./*.cdr ./*.jsonl ./*.log told.*
started=
trap 'for one in $started; do kill "$one" 2>/dev/null || true; done' EXIT

fail() {
  echo "FAILED: $1"
  tail -n 20 ./*.log
  exit 1
}
# robot LOG FLAGS...: starts one.
robot() {
  log=$1
  shift
  "$programs/corbslam_ros2" --agent alpha "$@" \
    -r visual_slam/image_0:=/camera/left/image -r visual_slam/image_1:=/camera/right/image \
    -r visual_slam/camera_info_0:=/camera/left/camera_info -r visual_slam/camera_info_1:=/camera/right/camera_info \
    >"$log" 2>&1 &
  robot=$!
  started="$started $robot"
}
# says LOG SECONDS TEXT: waits for a line.
says() {
  for _ in $(seq 1 $((10 * $2))); do
    grep -q -e "$3" "$1" && return
    sleep 0.1
  done
  fail "$1 does not say within $2 s: $3"
}

"$programs/corbslam" simulate --source 'sim:city?frames=0:45&picture_scale=0.5' --out city >/dev/null
node make_cdr.mjs city raw.cdr
node make_cdr.mjs city packed.cdr --compressed
node make_cdr.mjs city order.cdr --order

# Slower than the camera was, so that a busy machine does it, too.
# 1. What we publish, heard by Fast DDS and decoded by Foxglove; what these send, read by us.
robot raw.log --told told --stats stats.json --ros-args -p use_sim_time:=true
"$tests/dds_peer" hear heard.cdr --seconds 600 /visual_slam/tracking/odometry=nav_msgs/msg/Odometry \
  /visual_slam/tracking/vo_pose=geometry_msgs/msg/PoseStamped \
  /visual_slam/tracking/vo_pose_covariance=geometry_msgs/msg/PoseWithCovarianceStamped \
  /visual_slam/tracking/slam_path=nav_msgs/msg/Path /visual_slam/vis/landmarks_cloud=sensor_msgs/msg/PointCloud2 \
  /visual_slam/status=diagnostic_msgs/msg/DiagnosticStatus /diagnostics=diagnostic_msgs/msg/DiagnosticArray \
  /tf=tf2_msgs/msg/TFMessage dds:ros_discovery_info=rmw_dds_common/msg/ParticipantEntitiesInfo,latched \
  dds:rr/visual_slam/pause_mappingReply=std_srvs/srv/SetBool_Response \
  dds:rr/visual_slam/resetReply=std_srvs/srv/Trigger_Response >heard.log &
hear=$!
started="$started $hear"
"$tests/dds_peer" play raw.cdr --clock --sent sent.txt --speed 0.4
"$tests/dds_peer" play order.cdr --reliable --await 10
kill -TERM "$robot"
wait "$robot" || fail "corbslam_ros2 ended with $?"
kill -TERM "$hear"
wait "$hear"
cat heard.log
node decode_cdr.mjs heard.cdr heard.jsonl || fail "not all is to the byte what Foxglove encodes"
for topic in tracking/odometry tracking/vo_pose tracking/vo_pose_covariance tracking/slam_path vis/landmarks_cloud status; do
  grep -q "\"/visual_slam/$topic\"" heard.jsonl || fail "nothing was heard of $topic"
done
grep -q '"node_name":"visual_slam"' heard.jsonl || fail "the node is not in ros_discovery_info"
grep -q '"client":"12345678901234567890","number":"1","success":true,"message":"mapping is paused' heard.jsonl ||
  fail "pause_mapping was not answered"
grep -q '"number":"2","success":false,"message":"mapping is paused, and a new local map would stay empty' heard.jsonl ||
  fail "reset while paused was not refused"
grep -q '"number":"3","success":true' heard.jsonl || fail "mapping did not go on"
"$here/follow_tf.py" heard.jsonl --told told.local.tum --sent sent.txt --base 0.2,0,0.5,-0.5,0.5,-0.5,0.5 ||
  fail "map -> base_link is not the pose"
node -e 'const s = JSON.parse(require("fs").readFileSync("stats.json")); console.log(`${s.tracked} of ${s.frames} frames tracked`);
         process.exit(s.tracked >= 5 ? 0 : 1)' || fail "too few frames were tracked"

# 2. Pictures that are packed, from a best-effort publisher.
robot packed.log --stats stats.json --ros-args -p image_transport:=compressed
"$tests/dds_peer" play packed.cdr --speed 0.4
kill -TERM "$robot"
wait "$robot" || fail "corbslam_ros2 ended with $?"
node -e 'const s = JSON.parse(require("fs").readFileSync("stats.json")); process.exit(s.tracked >= 5 ? 0 : 1)' ||
  fail "too few frames of packed pictures were tracked"

# 3. What does not match is told within seconds.
robot quality.log --ros-args -p image_qos:=DEFAULT
"$tests/dds_peer" play raw.cdr --await 30 &
play=$!
started="$started $play"
says quality.log 30 '/camera/left/image is published with another quality of service (reliability).*qos_overrides./camera/left/image.subscription.reliability:=best_effort'
kill -TERM "$robot" "$play"
wait "$robot" || fail "a robot that waits does not end well: $?"
wait "$play" || true

# 4. What is wrong is refused before anything begins.
refused() {
  if "$programs/corbslam_ros2" "$@" >refused.log 2>&1; then fail "$* was taken"; fi
}
refused --ros-args -p no_such_parameter:=1
grep -q 'there is no parameter no_such_parameter' refused.log
refused --ros-args -r __ns:=/a-b
refused --ros-args --agent alpha
refused --source kitti:city
grep -q 'plays ros2:topics alone' refused.log
ROS_DOMAIN_ID=233 refused
grep -q "ROS_DOMAIN_ID is '233'" refused.log
echo "all is well"
