#!/usr/bin/env python3
"""Many sessions of one street: what a map grows by when it is driven again and again.

Robots drive the same simulated way one after the other, each half a frame or so aside, in other light
and with other noise, into one mission (one worker); between two of them fusion comes to rest. Printed
after each: keyframes and points in the store, keyframes of the global layer (those that the last global
adjustment had, which leaves out what was culled), the robot's own error and keyframes, bytes each way and
the store's memory. Programs are found in --bin.
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
    parser.add_argument("--json", help="file for the results")
    return parser.parse_args()


def statistics(store):
    """Waits until fusion rests."""
    for _ in range(1200):
        asked = store.run("ask", store.address, "corbslam.v1.MapStore/GetStatistics",
                          '{"mission": "missions/m"}', "--insecure")
        if asked.returncode != 0:
            sys.exit(asked.stderr)
        found = json.loads(asked.stdout)
        if found["mission"].get("fusionIdle"):
            return found
        time.sleep(0.5)
    sys.exit("fusion does not come to rest")


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


def main():
    arguments = parse_arguments()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        store = Store(arguments.bin, folder)
        try:
            time.sleep(1)
            for i in range(arguments.sessions):
                report, poses = drive(store, arguments, folder, i)
                found = statistics(store)["mission"]
                adjusted = found.get("adjustments", [])
                rows.append({
                    "session": i + 1, "keyframes": int(found["keyframes"]),
                    "points": int(found["mapPoints"]),
                    "in_adjustment": int(adjusted[-1].get("keyframes", 0)) if adjusted else None,
                    "own_keyframes": report["keyframes"], "lost": report["lost"],
                    "ate_m": error_of(store, arguments, folder, poses),
                    "others_percent": report["shared"]["points_matched_percent"],
                    "up_mb": report["bytes_up"] / 1e6, "down_mb": report["bytes_down"] / 1e6,
                    "store_mb": memory_mb(store.children[1].pid)})
                if i == 0:
                    print("  ".join(rows[0]))
                print("  ".join(f"{value:.3f}" if isinstance(value, float) else str(value)
                                for value in rows[-1].values()), flush=True)
        finally:
            store.stop()
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
