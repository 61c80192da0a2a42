#!/usr/bin/env python3
"""Many starts of one robot on one street: what a mission grows by over the years.

One robot starts again and again, under one name, and drives the same few frames of a simulated way, each
time a part of a frame aside, in other light and with other noise, into one mission (one worker); between
two starts fusion comes to rest. The whole is done once for each set of the store's flags in --stores: with
--keep-local-maps 1, so that all old local maps that may become one do, and as the store does it by itself.
A row after each start (of --rows of them): local maps, parts of others among what the robot opened,
keyframes, what the mission takes in memory and on disk as the store says, the store's resident memory, the
seconds that the drive took, and those until fusion rested. At the end the error of all sessions' poses as
the store has them then, under one alignment. Programs are found in --bin.
"""
import argparse
import json
import pathlib
import sys
import tempfile
import time

from localize import Store, with_options
from sessions import ask, memory_mb, statistics, text_of

ROBOT = "r"


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--drive", default="sim:city?seed=7&length=300")
    parser.add_argument("--frames", type=int, default=60, help="of the drive, from its begin")
    parser.add_argument("--starts", type=int, default=100)
    parser.add_argument("--stores", default="--keep-local-maps 1|",
                        help="flags of the store, of one run after the other, with | between")
    parser.add_argument("--rows", type=int, default=20, help="so many are printed; the JSON has all")
    parser.add_argument("--json", help="file for the results")
    arguments = parser.parse_args()
    if arguments.starts < 1 or arguments.frames < 1 or arguments.rows < 1:
        parser.error("--starts, --frames and --rows: give at least 1")
    return arguments


def drive(store, arguments, folder, i):
    """One start; its report."""
    light = f"phase={(0.37 * i) % 1:.2f}&exposure={1 - 0.04 * (i % 8):.2f}&noise_seed={i + 1}"
    source = with_options(arguments.drive, f"frames=0:{arguments.frames - 1}&{light}")
    stats = folder / "stats.json"
    stats.unlink(missing_ok=True)
    run = store.run("simulated_agent", "--source", source, "--server", store.address, "--insecure",
                    "--mission", "m", "--agent", ROBOT, "--pace", "max", "--poses-of", "rectified",
                    "--stats", str(stats))
    if run.returncode != 0 or not stats.exists():
        sys.exit(f"start {i + 1}: {run.stderr[-4000:]}")
    return json.loads(stats.read_text())


def joined(store):
    """How many local maps are parts of others by now."""
    count, page = 0, ""
    while True:
        answer = ask(store, "ListLocalMaps", {"parent": "missions/m", "pageToken": page})
        count += sum(len(one.get("joinedLocalMaps", [])) for one in answer.get("localMaps", []))
        page = answer.get("nextPageToken", "")
        if not page:
            return count


def row_of(store, arguments, folder, i):
    begin = time.monotonic()
    report = drive(store, arguments, folder, i)
    driven = time.monotonic()
    statistics(store)
    rested = time.monotonic()
    mission = ask(store, "GetMission", {"name": "missions/m"})
    return {"start": i + 1, "local_maps": int(mission.get("localMaps", 0)), "joined": joined(store),
            "islands": int(mission.get("islands", 0)), "keyframes": int(mission.get("keyframes", 0)),
            "points": int(mission.get("mapPoints", 0)), "lost": report["lost"],
            "mission_mb": int(mission.get("memoryBytes", 0)) / 2**20,
            "disk_mb": int(mission.get("diskBytes", 0)) / 2**20,
            "store_mb": memory_mb(store.children[1].pid),
            "drive_s": driven - begin, "fusion_s": rested - driven}


def sessions_of(poses):
    """The lines of a trajectory, apart where its clock begins anew."""
    sessions, newest = [], None
    for line in poses.read_text().splitlines():
        if line.startswith("#") or not line.strip():
            continue
        stamp = float(line.split()[0])
        if newest is None or stamp <= newest:
            sessions.append([])
        sessions[-1].append(line)
        newest = stamp
    return sessions


def error_at_the_end(store, arguments, folder):
    """Of all poses under one alignment, in metres, and of how many sessions; None: it was refused."""
    whole = folder / "whole.tum"
    exported = store.run("corbslam", "mission", "export", "--server", store.address, "--insecure",
                         "--mission", "m", "--agent", ROBOT, "--poses-of", "rectified", "--format",
                         "tum", "--out", str(whole))
    if exported.returncode != 0:
        print(exported.stderr, file=sys.stderr)
        return None, 0
    files = []
    # Sessions whose times are the same come in files of their own: whole+2.tum.
    exported = sorted(folder.glob("whole*.tum"))
    sessions = [lines for poses in exported for lines in sessions_of(poses)]
    for i, lines in enumerate(sessions):
        # A session of fewer poses says nothing of its own shape.
        if len(lines) < 3:
            continue
        files.append(folder / f"session{i}.tum")
        files[-1].write_text("\n".join(lines) + "\n")
    out = folder / "errors.json"
    run = store.run("corbslam", "eval", "--truth", arguments.drive, "--max-gap", "0.06", "--poses-of",
                    "rectified", "--json", str(out), *[str(file) for file in files])
    if run.returncode != 0:
        print(run.stderr, file=sys.stderr)
        return None, len(files)
    return json.loads(out.read_text())[-1]["ate_m"], len(files)


def run_all(arguments, flags):
    rows = []
    step = max(1, arguments.starts // arguments.rows)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        store = Store(arguments.bin, folder, "--data-dir", str(folder / "journal"), *flags)
        try:
            time.sleep(1)
            for i in range(arguments.starts):
                rows.append(row_of(store, arguments, folder, i))
                if i == 0:
                    print("  ".join(rows[0]))
                if i % step == 0 or i + 1 == arguments.starts:
                    print(text_of(rows[-1].values()), flush=True)
            error, sessions = error_at_the_end(store, arguments, folder)
        finally:
            store.stop()
    print(f"error of {sessions} sessions at the end under one alignment, m:", text_of([error]),
          flush=True)
    return {"flags": flags, "starts": rows, "sessions_at_the_end": sessions,
            "ate_at_the_end_m": error}


def main():
    arguments = parse_arguments()
    runs = []
    for flags in arguments.stores.split("|"):
        print(f"map_store {flags}".rstrip(), flush=True)
        runs.append(run_all(arguments, flags.split()))
        # What was measured is kept if a later run fails.
        if arguments.json:
            pathlib.Path(arguments.json).write_text(json.dumps(runs, indent=2))


if __name__ == "__main__":
    main()
