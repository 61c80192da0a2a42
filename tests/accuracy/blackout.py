#!/usr/bin/env python3
"""How soon a robot is told where it is in the global frame: at its start, and after a hand before its lens.

A robot maps a simulated drive at the sensor's pace (alone, in a store with one worker), and another one
drives the same way after it, with a hand before both lenses for a while. Agent.WatchPose of each is
followed. Prints, and writes with --json, for each: poses told, of these with a pose in the global frame,
when the first came, and how long after the hand had gone (it takes 0.3 s to go) the global pose was. Right is what lies within
0.5 m and 5 degrees of where the first robot had that place; how far a pose is from where the camera truly
was is said beside it: that has in it what the map drifted. Programs are found in --bin; the messages'
Python code in --messages (docs/clients.md says how to make it). Wants Debian's python3-grpcio.
"""
import argparse
import importlib
import json
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

import grpc

from localize import Store, at_rest, errors_of, free_port, poses_of, rotate, with_options


RECTIFIED_CAMERA = 2  # PosesOf.POSES_OF_RECTIFIED_CAMERA


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--messages", required=True, help="folder of the messages' Python code")
    parser.add_argument("--drive", default="sim:city?seed=7&length=400&picture_scale=0.5")
    parser.add_argument("--frames", type=int, default=250)
    parser.add_argument("--hand", default="8:3", help="FROM:DURATION of the hand, seconds of the drive")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--json", help="file for the results")
    return parser.parse_args()


def multiply(p, q):
    a, b, c, d = p
    w, x, y, z = q
    return (a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w)


class Follower:
    """Follows a robot's pose; says of each frame whether it was told one, and where."""

    def __init__(self, arguments, address):
        sys.path.insert(0, arguments.messages)
        self.agent = importlib.import_module("corbslam.v1.agent_service_pb2")
        stubs = importlib.import_module("corbslam.v1.agent_service_pb2_grpc")
        self.frames = []
        self.stub = stubs.AgentStub(grpc.insecure_channel(address))
        self.thread = threading.Thread(target=self.follow, daemon=True)
        self.thread.start()

    def follow(self):
        request = self.agent.WatchPoseRequest(poses_of=RECTIFIED_CAMERA)
        try:
            for pose in self.stub.WatchPose(request, wait_for_ready=True):
                self.frames.append(self.read(pose))
        except grpc.RpcError:
            pass  # The robot ended.

    def read(self, pose):
        told = pose.HasField("local_from_camera")
        place = None
        if told and pose.HasField("global_from_local"):
            similarity, rigid = pose.global_from_local, pose.local_from_camera
            q = tuple(similarity.rotation_wxyz)
            moved = rotate(q, list(rigid.translation))
            turned = multiply(q, tuple(rigid.rotation_wxyz))
            scale = similarity.scale if similarity.HasField("scale") else 1
            place = {"position_m": [scale * x + t
                                    for x, t in zip(moved, similarity.translation)],
                     "forward": rotate(turned, (0, 0, 1))}
        return {"t": 1e-9 * pose.timestamp_ns, "told": told, "place": place}


def drive(store, arguments, folder, name, options):
    address = f"127.0.0.1:{free_port()}"
    follower = Follower(arguments, address)
    source = with_options(arguments.drive, f"frames=0:{arguments.frames - 1}{options}")
    run = store.run("simulated_agent", "--source", source, "--server", store.address, "--insecure",
                    "--mission", "m", "--agent", name, "--pace", "sensor", "--listen", address,
                    "--stats", str(folder / f"{name}.json"))
    if run.returncode != 0:
        sys.exit(run.stderr)
    follower.thread.join(10)
    return follower.frames


def true_path(store, arguments, folder):
    """Where the camera was, in the global frame: that of the first robot's first frame. Not turned."""
    drawn = store.run("corbslam", "simulate", "--layout", "kitti", "--out", str(folder / "drawn"),
                      "--source", with_options(arguments.drive, f"frames=0:{arguments.frames - 1}"))
    if drawn.returncode != 0:
        sys.exit(drawn.stderr)
    times = [float(line) for line in open(folder / "drawn/times.txt")]
    poses = [[float(word) for word in line.split()] for line in open(folder / "drawn/poses.txt")]
    first = poses[0]
    path = []
    for t, pose in zip(times, poses):
        away = [pose[i] - first[i] for i in (3, 7, 11)]
        path.append([t, *(sum(first[4 * row + axis] * away[row] for row in range(3))
                          for axis in range(3)), 0, 0, 0, 1])
    return path


def row_of(name, frames, truth, path, hand):
    """`hand`: when it came before the lens and when it was gone, seconds of the drive, or None."""
    first = next((f["t"] for f in frames if f["place"]), None)
    after = [f for f in frames if hand and f["t"] >= hand[0]]
    dark = next((i for i, f in enumerate(after) if not f["told"]), len(after))
    again = next((f["t"] - hand[1] for f in after[dark:] if f["place"]), None)
    tracked = next((f["t"] - hand[1] for f in after[dark:] if f["told"]), None)
    placed = [f for f in frames if f["place"] and truth[0][0] <= f["t"] <= truth[-1][0]]
    errors = [errors_of(f["place"], truth, f["t"]) for f in placed]
    from_path = [errors_of(f["place"], path, f["t"])[0] for f in placed]
    return {"robot": name, "frames": len(frames), "poses": sum(f["told"] for f in frames),
            "global_poses": sum(f["place"] is not None for f in frames),
            "wrong": sum(m > 0.5 or d > 5 for m, d in errors),
            "worst_m": max((m for m, _ in errors), default=None),
            "worst_from_true_path_m": max(from_path, default=None),
            "first_global_s": first if first is None else first - frames[0]["t"],
            "tracked_after_hand_s": tracked, "global_after_hand_s": again}


def main():
    arguments = parse_arguments()
    start, duration = (float(word) for word in arguments.hand.split(":"))
    rows = []
    for run in range(arguments.runs):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            store = Store(arguments.bin, folder)
            try:
                time.sleep(1)
                first = drive(store, arguments, folder, "a", "")
                at_rest(store)
                truth = poses_of(store, folder)
                path = true_path(store, arguments, folder)
                second = drive(store, arguments, folder, "b", "&phase=0.5&noise_seed=2"
                               f"&hand={arguments.hand}")
            finally:
                store.stop()
        rows.append({"run": run, **row_of("first", first, truth, path, None)})
        rows.append({"run": run, **row_of("after it, a hand", second, truth, path,
                                          (start, start + duration))})
        for row in rows[-2:]:
            print("  ".join(f"{key} {value:.3f}" if isinstance(value, float) else f"{key} {value}"
                            for key, value in row.items()), flush=True)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
