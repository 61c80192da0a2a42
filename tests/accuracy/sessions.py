#!/usr/bin/env python3
"""Many sessions of one street: what a map grows by when it is driven again and again.

Robots drive the same simulated way one after the other, each half a frame or so aside, in other light
and with other noise, into one mission (one worker); between two of them fusion comes to rest, and the
store lets go of what it can do without. The whole is done twice: as it is, and with --keep-everything.
Printed after each session: keyframes and points in the store, what the store let go of, the keyframes
that the last global adjustment had, the robot's own keyframes and error, bytes each way, what the
mission takes in memory and on disk as the store says, and the store's resident memory. At the end of
each run the errors of all sessions' trajectories as the store has them then. Programs are found in --bin.
"""
import argparse
import json
import pathlib
import sys
import tempfile
import time

from localize import Store, with_options


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--drive", default="sim:city?seed=7&length=300")
    parser.add_argument("--sessions", type=int, default=10)
    parser.add_argument("--flags", default="", help="of robots from the second one on")
    parser.add_argument("--stores", default="|--keep-everything",
                        help="flags of the store, of one run after the other, with | between")
    parser.add_argument("--json", help="file for the results")
    return parser.parse_args()


def ask(store, method, request):
    asked = store.run("ask", store.address, f"corbslam.v1.MapStore/{method}", json.dumps(request),
                      "--insecure")
    if asked.returncode != 0:
        sys.exit(asked.stderr)
    return json.loads(asked.stdout)


def statistics(store):
    """Waits until fusion rests."""
    for _ in range(1200):
        found = ask(store, "GetStatistics", {"mission": "missions/m"})
        if found["mission"].get("fusionIdle"):
            return found
        time.sleep(0.5)
    sys.exit("fusion does not come to rest")


def let_go(store):
    """Keyframes that retired and points that faded, of all local maps."""
    local_maps = ask(store, "ListLocalMaps", {"parent": "missions/m"}).get("localMaps", [])
    return (sum(int(one.get("retiredKeyframes", 0)) for one in local_maps),
            sum(int(one.get("fadedMapPoints", 0)) for one in local_maps))


def memory_mb(pid):
    for line in open(f"/proc/{pid}/status"):
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return None


def drive(store, arguments, folder, i):
    light = f"&phase={(0.37 * i) % 1:.2f}&exposure={1 - 0.04 * (i % 8):.2f}&noise_seed={i + 1}"
    stats, poses = folder / f"{i}.json", folder / f"{i}.tum"
    flags = arguments.flags.split() if i > 0 else []
    run = store.run("simulated_agent", "--source", with_options(arguments.drive, light[1:]), "--server",
                    store.address, "--insecure", "--mission", "m", "--agent", f"r{i}", "--pace", "max",
                    "--poses-of", "rectified", "--stats", str(stats), "--trajectory", str(poses), *flags)
    if not stats.exists():
        sys.exit(run.stderr)
    return json.loads(stats.read_text()), poses


def error_of(store, arguments, folder, poses):
    out = folder / "errors.json"
    run = store.run("corbslam", "eval", "--truth", arguments.drive, "--max-gap", "0.06", "--poses-of",
                    "rectified", "--json", str(out), str(poses))
    return json.loads(out.read_text())[0]["ate_m"] if run.returncode == 0 else None


def errors_at_the_end(store, arguments, folder, sessions):
    errors = []
    for i in range(sessions):
        poses = folder / f"end{i}.tum"
        run = store.run("corbslam", "mission", "export", "--server", store.address, "--insecure",
                        "--mission", "m", "--agent", f"r{i}", "--poses-of", "rectified", "--format",
                        "tum", "--out", str(poses))
        if run.returncode != 0:
            print(run.stderr, file=sys.stderr)
        errors.append(error_of(store, arguments, folder, poses) if run.returncode == 0 else None)
    return errors


def row_of(store, arguments, folder, i):
    report, poses = drive(store, arguments, folder, i)
    found = statistics(store)["mission"]
    mission = ask(store, "GetMission", {"name": "missions/m"})
    adjusted = found.get("adjustments", [])
    retired, faded = let_go(store)
    return {"session": i + 1, "keyframes": int(found["keyframes"]), "points": int(found["mapPoints"]),
            "retired": retired, "faded": faded,
            "in_adjustment": int(adjusted[-1].get("keyframes", 0)) if adjusted else None,
            "own_keyframes": report["keyframes"], "lost": report["lost"],
            "ate_m": error_of(store, arguments, folder, poses),
            "others_percent": report["shared"]["points_matched_percent"],
            "up_mb": report["bytes_up"] / 1e6, "down_mb": report["bytes_down"] / 1e6,
            "mission_mb": int(mission.get("memoryBytes", 0)) / 2**20,
            "disk_mb": int(mission.get("diskBytes", 0)) / 2**20,
            "store_mb": memory_mb(store.children[1].pid)}


def text_of(values):
    return "  ".join(f"{value:.3f}" if isinstance(value, float) else str(value) for value in values)


def run_all(arguments, flags):
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        store = Store(arguments.bin, folder, "--data-dir", str(folder / "journal"), *flags)
        try:
            time.sleep(1)
            for i in range(arguments.sessions):
                rows.append(row_of(store, arguments, folder, i))
                if i == 0:
                    print("  ".join(rows[0]))
                print(text_of(rows[-1].values()), flush=True)
            errors = errors_at_the_end(store, arguments, folder, arguments.sessions)
            print("ATE of each session at the end, m:", text_of(errors), flush=True)
        finally:
            store.stop()
    return {"flags": flags, "sessions": rows, "ate_at_the_end_m": errors}


def main():
    arguments = parse_arguments()
    runs = []
    for flags in arguments.stores.split("|"):
        print(f"map_store {flags}".rstrip(), flush=True)
        runs.append(run_all(arguments, flags.split()))
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(runs, indent=2))


if __name__ == "__main__":
    main()
