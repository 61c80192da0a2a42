#!/usr/bin/python3
"""Follows TF as a client of ROS 2 would, with nothing of ours: of what dds_peer heard and decode_cdr.mjs decoded.

    follow_tf.py DECODED.jsonl [--told FILE.global.tum] [--sent FILE] [--base x,y,z,qx,qy,qz,qw]

At each stamp of a pose in the map (vo_pose), map -> base_link is looked up in what /tf said of that stamp and of no
other, and compared with the pose; with --told also with the pose that the robot told of the camera, which sits in
base_link as --base says, turned into a map with z up. --sent (of dds_peer play) gives the time from picture to pose.
"""
import argparse
import json
import math
import sys


def times(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def turned(q, v):
    x, y, z, _ = times(times(q, (*v, 0.0)), (-q[0], -q[1], -q[2], q[3]))
    return (x, y, z)


def chained(a, b):
    moved = turned(a[1], b[0])
    return (tuple(p + m for p, m in zip(a[0], moved)), times(a[1], b[1]))


def vector(v):
    return (v["x"], v["y"], v["z"])


def quaternion(q):
    return (q["x"], q["y"], q["z"], q["w"])


def apart(a, b):
    metres = math.dist(a[0], b[0])
    # The sine of half the angle: the cosine can't tell small ones.
    x, y, z, _ = times((-a[1][0], -a[1][1], -a[1][2], a[1][3]), b[1])
    return metres, 2 * math.asin(min(1.0, math.hypot(x, y, z)))


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("decoded")
    parser.add_argument("--told")
    parser.add_argument("--sent")
    parser.add_argument("--prefix", default="")
    parser.add_argument("--base", default="0,0,0,0,0,0,1")
    arguments = parser.parse_args()
    transforms, poses, odometry, arrived = {}, {}, {}, {}
    for text in open(arguments.decoded):
        line = json.loads(text)
        message, topic = line["message"], line["topic"]
        if topic == arguments.prefix + "/tf":
            for one in message["transforms"]:
                key = (int(one["header"]["stamp"]), one["header"]["frame_id"], one["child_frame_id"])
                if key in transforms:
                    sys.exit(f"{key} was published twice")
                transforms[key] = (vector(one["transform"]["translation"]), quaternion(one["transform"]["rotation"]))
        elif topic == arguments.prefix + "/visual_slam/tracking/vo_pose":
            stamp = int(message["header"]["stamp"])
            poses[stamp] = (vector(message["pose"]["position"]), quaternion(message["pose"]["orientation"]))
            arrived[stamp] = int(line["time_ns"])
        elif topic == arguments.prefix + "/visual_slam/tracking/odometry":
            pose = message["pose"]["pose"]
            odometry[int(message["header"]["stamp"])] = (vector(pose["position"]), quaternion(pose["orientation"]))
    base_from_camera = [float(n) for n in arguments.base.split(",")]
    base_from_camera = (tuple(base_from_camera[:3]), tuple(base_from_camera[3:]))
    told = {}
    if arguments.told:
        for row in open(arguments.told):
            if not row.startswith("#"):
                time, *numbers = row.split()
                seconds, _, rest = time.partition(".")
                numbers = [float(n) for n in numbers]
                told[int(seconds) * 10**9 + int(rest.ljust(9, "0")[:9])] = (tuple(numbers[:3]), tuple(numbers[3:]))
    level = ((0.0, 0.0, 0.0), (-0.5, 0.5, -0.5, 0.5))
    worst, worst_told, missing, compared = (0.0, 0.0), (0.0, 0.0), 0, 0
    for stamp, pose in poses.items():
        odom = transforms.get((stamp, "odom", "base_link"))
        up = transforms.get((stamp, "map", "odom"))
        if odom is None or up is None:
            missing += 1
            continue
        if odom != odometry.get(stamp, odom):
            sys.exit(f"{stamp}: odom -> base_link is not the odometry's pose")
        looked_up = chained(up, odom)
        worst = tuple(map(max, worst, apart(looked_up, pose)))
        if stamp in told:
            compared += 1
            worst_told = tuple(map(max, worst_told, apart(chained(looked_up, base_from_camera),
                                                          chained(level, told[stamp]))))
    extra = {stamp for stamp, parent, _ in transforms if parent == "map"} - set(poses)
    print(f"{len(poses)} poses, {missing} of them without map -> odom -> base_link of their stamp; "
          f"{len(extra)} stamps of map -> odom without a pose; "
          f"looked up and told differ by {worst[0]:.2e} m, {worst[1]:.2e} rad at most")
    if arguments.told:
        print(f"{compared} of {len(told)} poses that the robot told: {worst_told[0]:.2e} m, {worst_told[1]:.2e} rad")
    if arguments.sent:
        sent = {}
        for row in open(arguments.sent):
            topic, stamp, time = row.split()
            if "image" in topic:
                sent[int(stamp)] = max(sent.get(int(stamp), 0), int(time))
        taken = [1e-6 * (arrived[stamp] - sent[stamp]) for stamp in poses if stamp in sent]
        if not taken:
            sys.exit("no pose was heard of a picture that was sent")
        print(f"picture sent to pose heard: p50 {percentile(taken, 0.5):.1f} ms, p99 {percentile(taken, 0.99):.1f} ms, "
              f"{len(taken)} frames of {len(sent)}")
    # A pose is in the messages as doubles: composing them is all that may differ.
    sys.exit(0 if poses and missing == 0 and not extra and worst[0] < 1e-6 and worst[1] < 1e-6
             and worst_told[0] < 1e-5 and worst_told[1] < 1e-5 else 1)


main()
