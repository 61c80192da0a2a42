#!/usr/bin/env python3
"""What a robot gains where another one has been: found in the dark, and driven across.

A robot maps a simulated drive (alone, in a store with one worker). Then:
* other robots are started at frames all over it, without knowing where: how long from a robot's first frame
  to the first pose in the global frame that it tells, and how wrong are those. Right is what lies within 0.5 m
  and 5 degrees of where the first robot itself had that place in its map: the map's own error is not counted.
* a second robot drives all of it again, in other light, with sharing on and off: its errors, lost frames,
  keyframes, and what others' map had in it.
Prints tables, and JSON with --json. Programs are found in --bin.
"""
import argparse
import json
import pathlib
import sys
import tempfile
import time

from localize import Store, build_map, errors_of, percentile, read_tum, rotate, with_options

KINDS = {"the same": "", "half a frame later": "&phase=0.5&noise_seed=2",
         "darker": "&phase=0.5&exposure=0.6&noise_seed=3"}


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--drive", default="sim:city?seed=7&length=1500")
    parser.add_argument("--frames", type=int, default=900, help="of the drive that is mapped")
    parser.add_argument("--starts", type=int, default=200, help="of each kind and mode")
    parser.add_argument("--start-frames", type=int, default=12, help="that each of these sees")
    parser.add_argument("--modes", default="localises only,maps")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--crossings", type=int, default=3, help="with each way of sharing")
    parser.add_argument("--json", help="file for the results")
    return parser.parse_args()


def ask(store, *arguments):
    run = store.run("corbslam", "mission", *arguments, "--server", store.address, "--insecure")
    if run.returncode != 0:
        sys.exit(run.stderr)


class Copy:
    """A mission of its own that begins as the first robot's map: what others add stays in it."""

    def __init__(self, store, folder, name):
        self.store, self.name = store, name
        ask(store, "restore", "--file", str(folder / "map.backup"), "--mission", name)

    def __enter__(self):
        return self.name

    def __exit__(self, *_):
        ask(self.store, "delete", "--mission", self.name)


def drive(store, folder, mission, source, name, *flags):
    """Runs a robot; returns its report and its poses in its own frame."""
    stats, poses = folder / f"{name}.json", folder / f"{name}.tum"
    run = store.run("simulated_agent", "--source", source, "--server", store.address, "--insecure",
                    "--mission", mission, "--agent", name, "--poses-of", "rectified", "--stats", str(stats),
                    "--trajectory", str(poses), *flags)
    if not stats.exists():
        sys.exit(run.stderr)
    report = json.loads(stats.read_text())
    return report, read_tum(poses) if poses.exists() else []


def start_anywhere(store, arguments, folder, mission, kind, mode, truth):
    first = 20
    last = arguments.frames - arguments.start_frames - 20
    seconds, metres, degrees, wrong, places = [], [], [], 0, 0
    for i in range(arguments.starts):
        at = first + (last - first) * i // max(1, arguments.starts - 1)
        source = with_options(arguments.drive,
                              f"frames={at}:{at + arguments.start_frames - 1}{KINDS[kind]}")
        flags = ["--pace", "sensor"] + (["--localise-only"] if mode == "localises only" else [])
        flags += ["--share", "nearby"]
        # A robot's name has no memory: each is a stranger.
        report, poses = drive(store, folder, mission, source, f"r{i}", *flags)
        places += report["shared"]["places_told"]
        if report["shared"]["located_after_s"] is not None:
            seconds.append(report["shared"]["located_after_s"])
        if mode != "localises only":
            continue  # Its own poses are in its own frame.
        for pose in poses:
            answer = {"position_m": pose[1:4], "forward": rotate((pose[7], *pose[4:7]), (0, 0, 1))}
            error_m, error_deg = errors_of(answer, truth, pose[0])
            metres.append(error_m)
            degrees.append(error_deg)
            wrong += error_m > 0.5 or error_deg > 5
    return {"kind": kind, "mode": mode, "starts": arguments.starts, "located": len(seconds),
            "within_1s": sum(s <= 1 for s in seconds), "p50_s": percentile(seconds, 0.5),
            "p95_s": percentile(seconds, 0.95), "worst_s": max(seconds, default=None),
            "poses": len(metres), "wrong_poses": wrong, "median_m": percentile(metres, 0.5),
            "worst_m": max(metres, default=None), "worst_deg": max(degrees, default=None),
            "places_told": places}


def error_of(store, arguments, folder, poses_file):
    out = folder / "errors.json"
    run = store.run("corbslam", "eval", "--truth", arguments.drive, "--max-gap", "0.06", "--poses-of",
                    "rectified", "--json", str(out), str(poses_file))
    if run.returncode != 0:
        sys.exit(run.stderr)
    return json.loads(out.read_text())[0]["ate_m"]


def cross(store, arguments, folder, share, run):
    source = with_options(arguments.drive,
                          f"frames=0:{arguments.frames - 1}{KINDS['darker']}")
    name = f"cross_{share.replace('-', '')}_{run}"
    flags = ["--localise-only"] if share == "localise-only" else ["--share", share]
    with Copy(store, folder, name) as mission:
        report, _ = drive(store, folder, mission, source, name, "--pace", "max", *flags)
    return {"share": share, "run": run, "frames": report["frames"], "tracked": report["tracked"],
            "lost": report["lost"], "local_maps": report["local_maps"],
            "ate_m": error_of(store, arguments, folder, folder / f"{name}.tum"),
            "keyframes": report["keyframes"], "located_after_s": report["shared"]["located_after_s"],
            "others_percent": report["shared"]["points_matched_percent"],
            "held": report["shared"]["keyframes_held"], "down_mb": report["bytes_down"] / 1e6,
            "tracking_p99_ms": report["tracking_ms"]["p99"]}


def print_rows(rows):
    if not rows:
        return
    print("\n" + "  ".join(rows[0]))
    for row in rows:
        print("  ".join(f"{value:.3f}" if isinstance(value, float) else str(value)
                        for value in row.values()), flush=True)


def main():
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        store = Store(arguments.bin, folder)
        try:
            time.sleep(1)
            mission, truth = build_map(store, arguments, folder)
            ask(store, "backup", "--mission", "m", "--out", str(folder / "map.backup"))
            starts = []
            for mode in arguments.modes.split(",") if arguments.starts else []:
                for kind in arguments.kinds.split(","):
                    with Copy(store, folder, "starts") as copied:
                        starts.append(start_anywhere(store, arguments, folder, copied, kind, mode,
                                                     truth))
                        print_rows(starts[-1:])
            crossings = [cross(store, arguments, folder, share, run) for run in range(arguments.crossings)
                         for share in ("none", "localise-only", "everything")]
        finally:
            store.stop()
    print_rows(starts)
    print_rows(crossings)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(
            {"mission": mission, "starts": starts, "crossings": crossings}, indent=2))


if __name__ == "__main__":
    main()
