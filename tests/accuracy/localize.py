#!/usr/bin/env python3
"""Where was this picture taken: how often a map's answer is right, and how long it takes.

A robot maps a simulated drive (alone, in a store with one worker). Then pictures of the same drive are
looked up: the very same ones, others taken half a frame later, and others yet at another exposure.
Right is what lies within 0.5 m and 5 degrees of where the robot itself had that place in its map: the
map's own error is not counted, and the map must not have moved meanwhile. --keep FOLDER keeps the map,
or takes it from there. Prints a table, and JSON with --json. Programs are found in --bin.
"""
import argparse
import bisect
import json
import math
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time

KITTI_CAMERA = "718.856 718.856 607.1928 185.2157"
USUAL_EXPOSURE = 1.5  # What the simulator takes where a drive says nothing (docs/simulation.md).


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--drive", default="sim:city?seed=7&length=1500")
    parser.add_argument("--frames", type=int, default=1200, help="of the drive that is mapped")
    parser.add_argument("--pictures", type=int, default=200, help="that are looked up of each kind")
    parser.add_argument("--lights", default="0.6", help="shares of the mapped drive's light, by commas")
    parser.add_argument("--camera", default=KITTI_CAMERA, help="fx fy cx cy of its pictures")
    parser.add_argument("--keep", help="folder with map.backup: made, or used where it is there")
    parser.add_argument("--json", help="file for the results")
    return parser.parse_args()


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


class Store:
    """A map store with one worker, on this machine alone."""

    def __init__(self, programs, folder, *flags):
        self.programs = programs
        self.address = f"127.0.0.1:{free_port()}"
        worker = f"127.0.0.1:{free_port()}"
        self.children = [
            subprocess.Popen([f"{programs}/fusion_worker", "--listen", worker, "--insecure"],
                             stderr=open(folder / "worker.log", "w")),
            subprocess.Popen([f"{programs}/map_store", "--listen", self.address, "--worker", worker,
                              "--insecure", *flags], stderr=open(folder / "store.log", "w"))]

    def run(self, program, *arguments):
        return subprocess.run([f"{self.programs}/{program}", *arguments], capture_output=True,
                              text=True, check=False)

    def stop(self):
        for child in self.children:
            child.terminate()
        for child in self.children:
            child.wait()


def read_tum(path):
    poses = []
    for line in open(path):
        if not line.startswith("#") and line.strip():
            poses.append([float(word) for word in line.split()])
    return poses


def rotate(q, v):
    w, x, y, z = q
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]]


def pose_at(poses, t):
    """Position and viewing direction at a time, between the two frames around it."""
    times = [pose[0] for pose in poses]
    i = min(max(bisect.bisect_right(times, t), 1), len(poses) - 1)
    a, b = poses[i - 1], poses[i]
    share = min(max((t - a[0]) / (b[0] - a[0]), 0), 1)
    position = [(1 - share) * p + share * q for p, q in zip(a[1:4], b[1:4])]
    ahead = [[*rotate((pose[7], *pose[4:7]), (0, 0, 1))] for pose in (a, b)]
    direction = [(1 - share) * p + share * q for p, q in zip(*ahead)]
    length = math.sqrt(sum(x * x for x in direction))
    return position, [x / length for x in direction]


def errors_of(answer, poses, t):
    position, ahead = pose_at(poses, t)
    metres = math.dist(position, answer["position_m"])
    cosine = sum(a * b for a, b in zip(ahead, answer["forward"]))
    return metres, math.degrees(math.acos(min(1, max(-1, cosine))))


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else float("nan")


def with_options(source, options):
    return source + ("&" if "?" in source else "?") + options


def look_up(store, arguments, folder, name, options, poses):
    stride = max(1, arguments.frames // arguments.pictures)
    pictures = folder / name
    drawn = store.run("corbslam", "simulate", "--source",
                      with_options(arguments.drive,
                                   f"frames=0:{arguments.frames - 1}&stride={stride}{options}"),
                      "--layout", "kitti", "--out", str(pictures))
    if drawn.returncode != 0:
        sys.exit(drawn.stderr)
    times = [float(line) for line in open(pictures / "times.txt")]
    files = sorted((pictures / "image_0").glob("*.png"))[:arguments.pictures]
    asked = store.run("corbslam", "localize", "--server", store.address, "--insecure", "--mission",
                      "m", "--camera", arguments.camera, "--json", *map(str, files))
    if not asked.stdout:
        sys.exit(asked.stderr)
    answers = json.loads(asked.stdout)
    row = {"pictures": name, "asked": len(answers), "found": 0, "right": 0, "wrong": 0, "stages": {}}
    metres, degrees = [], []
    for answer, t in zip(answers, times):
        row["stages"][answer["stage"]] = row["stages"].get(answer["stage"], 0) + 1
        if not answer["located"]:
            continue
        error_m, error_deg = errors_of(answer, poses, t)
        right = error_m <= 0.5 and error_deg <= 5
        row["found"] += 1
        row["right" if right else "wrong"] += 1
        metres.append(error_m)
        degrees.append(error_deg)
    seconds = [answer["seconds"] for answer in answers]
    row.update(median_m=percentile(metres, 0.5), p95_m=percentile(metres, 0.95),
               worst_m=max(metres, default=float("nan")), worst_deg=max(degrees, default=float("nan")),
               p50_ms=1e3 * percentile(seconds, 0.5), p99_ms=1e3 * percentile(seconds, 0.99))
    return row


def kinds_of(arguments):
    lights = [(f"light {share}", f"&phase=0.5&exposure={USUAL_EXPOSURE * float(share):g}")
              for share in arguments.lights.split(",") if share]
    return [("the same", ""), ("half a frame later", "&phase=0.5"), *lights,
            ("gamma 1.4", "&phase=0.5&gamma=1.4")]


def map_drive(store, arguments):
    mapped = store.run("simulated_agent", "--source",
                       with_options(arguments.drive, f"frames=0:{arguments.frames - 1}"),
                       "--server", store.address, "--insecure", "--mission", "m", "--agent", "a")
    if mapped.returncode != 0:
        sys.exit(mapped.stderr)


def mission_of(store, *command):
    done = store.run("corbslam", "mission", *command, "--server", store.address, "--insecure",
                     "--mission", "m")
    if done.returncode != 0:
        sys.exit(done.stderr)
    return done.stdout


def at_rest(store):
    """The mission once fusion has nothing to do any more."""
    for _ in range(3600):
        mission = json.loads(mission_of(store, "show", "--json"))
        if mission["mission"]["fusion_idle"]:
            return mission
        time.sleep(1)
    sys.exit("fusion does not come to rest")


def poses_of(store, folder, agent="a"):
    out = folder / "a.tum"
    mission_of(store, "export", "--agent", agent, "--format", "tum", "--poses-of", "rectified",
               "--out", str(out))
    return read_tum(out)


def build_map(store, arguments, folder):
    map_drive(store, arguments)
    mission = at_rest(store)
    return mission, poses_of(store, folder)


def kept_map(store, arguments, folder):
    """As build_map, from a backup where there is one."""
    kept = pathlib.Path(arguments.keep) / "map.backup"
    if kept.exists():
        mission_of(store, "restore", "--file", str(kept))
    else:
        kept.parent.mkdir(parents=True, exist_ok=True)
        map_drive(store, arguments)
        at_rest(store)
        mission_of(store, "backup", "--out", str(kept))
    mission = at_rest(store)
    return mission, poses_of(store, folder)


def main():
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        store = Store(arguments.bin, folder)
        try:
            time.sleep(1)
            mission, poses = (kept_map if arguments.keep else build_map)(store, arguments, folder)
            keyframes = re.search(r'"keyframes":\s*(\d+)', json.dumps(mission))
            rows = [look_up(store, arguments, folder, kind, options, poses)
                    for kind, options in kinds_of(arguments)]
            after = poses_of(store, folder)
            moved = max(math.dist(a[1:4], b[1:4]) for a, b in zip(poses, after))
        finally:
            store.stop()
    if moved > 0.01:
        sys.exit(f"the map moved by {moved:.3f} m while pictures were looked up: no row is right")
    print(f"map of {keyframes.group(1) if keyframes else '?'} keyframes, {len(poses)} frames")
    print("pictures             asked right wrong  median m   p95 m worst m  p50 ms  p99 ms  stages")
    for row in rows:
        print(f"{row['pictures']:20} {row['asked']:5} {row['right']:5} {row['wrong']:5} "
              f"{row['median_m']:9.3f} {row['p95_m']:7.3f} {row['worst_m']:7.3f} {row['p50_ms']:7.1f} "
              f"{row['p99_ms']:7.1f}  {row['stages']}")
    if arguments.json:
        pathlib.Path(arguments.json).write_text(
            json.dumps({"keyframes": keyframes and int(keyframes.group(1)), "rows": rows}, indent=2))


if __name__ == "__main__":
    main()
