#!/usr/bin/env python3
"""One way driven again and again: what known ground costs.

A simulated way that comes back to where it began is drawn once. Robots drive it lap after lap into one
mission with one worker, each lap a session of its own, or (--gapless) all laps in one session; with
several robots each begins a share of a lap after the other. --starve FIRST:LAST:SHARE lets the worker
run for that share of each second in these laps. Printed after each lap (gapless: every five seconds): keyframes,
local maps and overlaps of the mission, look-ups that wait when the lap ends, seconds until fusion rests
(up to --rest), what the mission says that it takes, anonymous memory of store, worker and robot, the
journal's disk, keyframes that the lap made, and its error by its own end. Programs are found in --bin.
"""
import argparse
import contextlib
import json
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

from kitti_folder import link_frames
from localize import Store
from sessions import ask


def starving(text):
    first, last, share = text.split(":")
    return int(first), int(last), float(share)


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--drive", default="sim:city?seed=7&length=400")
    parser.add_argument("--laps", type=int, default=10)
    parser.add_argument("--robots", type=int, default=1)
    parser.add_argument("--gapless", action="store_true")
    parser.add_argument("--pace", default="max", choices=["max", "sensor"])
    parser.add_argument("--starve", type=starving, metavar="FIRST:LAST:SHARE")
    parser.add_argument("--rest", type=float, default=10, help="seconds to wait for fusion after a lap")
    parser.add_argument("--keep", help="folder of the drawn laps: made, or used where it is there")
    parser.add_argument("--json", help="file for the results")
    arguments = parser.parse_args()
    if arguments.gapless and arguments.starve:
        parser.error("--starve counts laps, and --gapless has no ends of laps")
    return arguments


def draw(arguments, folder):
    lap = folder / "lap"
    if not lap.exists():
        subprocess.run([f"{arguments.bin}/corbslam", "simulate", "--source", arguments.drive, "--layout",
                        "kitti", "--out", str(lap)], check=True, stderr=subprocess.DEVNULL)
    return lap


def position(pose):
    values = [float(word) for word in pose.split()]
    return values[3], values[7], values[11]


def distance(a, b):
    return sum((x - y) ** 2 for x, y in zip(position(a), position(b))) ** 0.5


def repeat(lap, laps, folder):
    """Links the lap's pictures into a recording that goes round so often."""
    times = lap.joinpath("times.txt").read_text().split()
    poses = lap.joinpath("poses.txt").read_text().splitlines()
    end = min(range(3 * len(poses) // 4, len(poses)), key=lambda i: distance(poses[i], poses[0]))
    rounds = folder / f"laps{laps}"
    shutil.rmtree(rounds, ignore_errors=True)
    link_frames(lap, [i % end for i in range(laps * end)], rounds)
    step = float(times[1]) - float(times[0])
    rounds.joinpath("times.txt").write_text(
        "".join(f"{i * step:e}\n" for i in range(laps * end)))
    rounds.joinpath("poses.txt").write_text("\n".join(poses[:end] * laps) + "\n")
    return rounds, end


def anonymous_mb(pid):
    try:
        for line in open(f"/proc/{pid}/smaps_rollup"):
            if line.startswith("Anonymous"):
                return round(int(line.split()[1]) / 1024, 1)
    except (FileNotFoundError, ProcessLookupError):
        pass
    return None


def start_robot(store, arguments, folder, source, name):
    stats = folder / f"{name}.json"
    stats.unlink(missing_ok=True)
    child = subprocess.Popen(
        [f"{arguments.bin}/client_agent", "--source", source, "--server", store.address, "--insecure",
         "--mission", "m", "--agent", name, "--pace", arguments.pace, "--finish", "60", "--stats",
         str(stats), "--trajectory", str(folder / f"{name}.tum"), "--told", str(folder / name)],
        stderr=open(folder / f"{name}.log", "a"))
    return child


def error_of(store, source, poses):
    out = poses.with_suffix(".error.json")
    run = store.run("corbslam", "eval", "--truth", source, "--json", str(out), str(poses))
    return round(json.loads(out.read_text())[0]["ate_m"], 4) if run.returncode == 0 else None


class Starved:
    """Lets a process run for a share of each second, until it ends."""

    def __init__(self, process, share):
        self.process, self.share, self.ended = process, share, threading.Event()
        self.thread = threading.Thread(target=self.run)

    def run(self):
        while not self.ended.is_set():
            self.process.send_signal(signal.SIGSTOP)
            self.ended.wait(1 - self.share)
            self.process.send_signal(signal.SIGCONT)
            self.ended.wait(self.share)

    def __enter__(self):
        self.thread.start()

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()


def starved_in(lap, store, arguments):
    first, last, share = arguments.starve or (0, 0, 1)
    return Starved(store.children[0], share) if first <= lap <= last else contextlib.nullcontext()


def measure(store):
    found = ask(store, "GetStatistics", {"mission": "missions/m"})["mission"]
    mission = ask(store, "GetMission", {"name": "missions/m"})
    return {"keyframes": int(mission.get("keyframes", 0)), "points": int(mission.get("mapPoints", 0)),
            "local_maps": int(mission.get("localMaps", 0)),
            "looked_up": int(found.get("overlapsVerified", 0)),
            "overlaps": int(found.get("overlapsAccepted", 0)),
            "waiting": int(mission.get("waitingQueries", 0)),
            "said_mb": round(int(mission.get("memoryBytes", 0)) / 2**20, 1),
            "store_mb": anonymous_mb(store.children[1].pid),
            "worker_mb": anonymous_mb(store.children[0].pid),
            "disk_mb": round(int(mission.get("diskBytes", 0)) / 2**20, 1)}


def rest(store, seconds):
    begin = time.time()
    while time.time() - begin < seconds:
        if ask(store, "GetMission", {"name": "missions/m"}).get("fusionIdle"):
            return round(time.time() - begin, 1)
        time.sleep(0.5)
    return None


def finish(row, store, arguments, folder, source, names):
    row["rests_after_s"] = rest(store, arguments.rest)
    waiting = row["waiting"]
    row.update(measure(store))
    row["waiting"], row["wait_after_rest"] = waiting, row["waiting"]
    reports = [json.loads((folder / f"{name}.json").read_text()) for name in names]
    row["made"] = [report["keyframes"] for report in reports]
    row["lost"] = [report["lost"] for report in reports]
    row["ate_m"] = [error_of(store, source, folder / f"{name}.tum") for name in names]
    row["told_m"] = [error_of(store, source, folder / f"{name}.global.tum") for name in names]
    return row


def drive_sessions(store, arguments, folder, lap):
    source = f"kitti:{lap}"
    frames = len(lap.joinpath("times.txt").read_text().split())
    for i in range(arguments.laps):
        with starved_in(i + 1, store, arguments):
            yield drive_lap(i + 1, frames, source, store, arguments, folder)


def drive_lap(lap, frames, source, store, arguments, folder):
    begin = time.time()
    names = [f"r{robot}" for robot in range(arguments.robots)]
    robots = []
    for robot, name in enumerate(names):
        first = robot * frames // (4 * arguments.robots)
        robots.append(start_robot(store, arguments, folder, f"{source}?frames={first}:{frames - 1}",
                                  name))
    for robot in robots:
        robot.wait()
    row = {"lap": lap, "seconds": round(time.time() - begin, 1), **measure(store)}
    return finish(row, store, arguments, folder, source, names)


def drive_gapless(store, arguments, folder, lap):
    rounds, frames = repeat(lap, arguments.laps, folder)
    source = f"kitti:{rounds}"
    names = [f"r{robot}" for robot in range(arguments.robots)]
    robots = [start_robot(store, arguments, folder,
                          f"{source}?frames={robot * frames // (4 * arguments.robots)}:"
                          f"{arguments.laps * frames - 1}", name) for robot, name in enumerate(names)]
    begin = time.time()
    while any(robot.poll() is None for robot in robots):
        time.sleep(5)
        yield {"seconds": round(time.time() - begin, 1), **measure(store),
               "robot_mb": [anonymous_mb(robot.pid) for robot in robots]}
    row = {"lap": arguments.laps, "seconds": round(time.time() - begin, 1), **measure(store)}
    yield finish(row, store, arguments, folder, source, names)


def main():
    arguments = parse_arguments()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        drawn = pathlib.Path(arguments.keep) if arguments.keep else folder
        drawn.mkdir(parents=True, exist_ok=True)
        lap = draw(arguments, drawn)
        store = Store(arguments.bin, folder, "--data-dir", str(folder / "journal"))
        try:
            time.sleep(1)
            drive = drive_gapless if arguments.gapless else drive_sessions
            for row in drive(store, arguments, folder, lap):
                rows.append(row)
                print(json.dumps(row), flush=True)
            slept = store.run("corbslam", "mission", "sleep", "--server", store.address, "--insecure",
                              "--mission", "m")
            print("sleep:", (slept.stdout + slept.stderr).strip(), flush=True)
        finally:
            store.stop()
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
