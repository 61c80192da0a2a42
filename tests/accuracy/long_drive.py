#!/usr/bin/env python3
"""A long drive with and without a memory budget: does the robot's memory stay where it is.

One robot drives a simulated way with --memory-budget and, beside it at the same time on the same machine,
another without; each has a map store (with a journal) and a worker of its own. Each second the robots' and
stores' resident memory is read. Printed: frames tracked, keyframes, hand-overs, memory by tenths of the time
from the first time the budget mattered, tracking's times, and errors. Programs are found in --bin.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

from localize import Store, with_options


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--drive", default="sim:city?seed=7&length=20000&picture_scale=0.5",
                        help="better recorded (corbslam simulate): a drawn town takes memory, too")
    parser.add_argument("--frames", type=int, default=0, help="of the drive; 0: all")
    parser.add_argument("--budget", default="500MB", help="0: none")
    parser.add_argument("--alone", action="store_true", help="without a run that has no budget beside it")
    parser.add_argument("--json", help="file for the results")
    return parser.parse_args()


def resident_mb(pid):
    try:
        for line in open(f"/proc/{pid}/status"):
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
    except FileNotFoundError:
        pass
    return None


class Run:
    """A robot with a store and a worker of its own."""

    def __init__(self, arguments, folder, name, flags):
        self.folder, self.name, self.arguments = folder, name, arguments
        self.memory, self.store_memory = [], []
        (folder / name).mkdir()
        self.store = Store(arguments.bin, folder / name, "--data-dir", str(folder / name / "journal"))
        time.sleep(1)
        source = arguments.drive
        if arguments.frames:
            source = with_options(source, f"frames=0:{arguments.frames - 1}")
        program = "simulated_agent" if source.startswith("sim:") else "client_agent"
        self.robot = subprocess.Popen(
            [f"{arguments.bin}/{program}", "--source", source, "--server", self.store.address,
             "--insecure", "--mission", "m", "--agent", name, "--pace", "max", "--poses-of", "rectified",
             "--stats", str(folder / f"{name}.json"), "--trajectory", str(folder / f"{name}.tum"), *flags],
            stderr=open(folder / f"{name}.log", "w"))

    def sample(self):
        if self.robot.poll() is None:
            self.memory.append(resident_mb(self.robot.pid))
            self.store_memory.append(resident_mb(self.store.children[1].pid))
            return True
        return False

    def error(self):
        """Of the whole trajectory, as the store has it once fusion rests."""
        for _ in range(900):
            shown = self.store.run("corbslam", "mission", "show", "--server", self.store.address,
                                   "--insecure", "--mission", "m", "--json")
            if shown.returncode == 0 and json.loads(shown.stdout)["mission"]["fusion_idle"]:
                break
            time.sleep(1)
        poses, out = self.folder / f"{self.name}.global.tum", self.folder / f"{self.name}.errors.json"
        exported = self.store.run("corbslam", "mission", "export", "--server", self.store.address,
                                  "--insecure", "--mission", "m", "--agent", self.name, "--format", "tum",
                                  "--poses-of", "rectified", "--out", str(poses))
        run = self.store.run("corbslam", "eval", "--truth", self.arguments.drive, "--max-gap", "0.06",
                             "--poses-of", "rectified", "--json", str(out), str(poses))
        if exported.returncode != 0 or run.returncode != 0:
            print(exported.stderr, run.stderr, file=sys.stderr)
            return None
        return json.loads(out.read_text())[0]

    def row(self):
        path = self.folder / f"{self.name}.json"
        if not path.exists():
            sys.exit((self.folder / f"{self.name}.log").read_text()[-4000:])
        report = json.loads(path.read_text())
        errors = self.error()
        memory = [one for one in self.memory if one]
        settled = memory[len(memory) // 5:] or memory
        tenths = [settled[i * len(settled) // 10:(i + 1) * len(settled) // 10] or settled
                  for i in range(10)]
        return {"run": self.name, "frames": report["frames"], "tracked": report["tracked"],
                "lost": report["lost"], "keyframes": report["keyframes"],
                "local_maps": report["local_maps"], "hand_overs": report["hand_overs"],
                "tracking_ms": report["tracking_ms"], "seconds": len(memory),
                "greatest_mb": max(memory), "last_mb": memory[-1],
                "settled_tenths_mb": [sum(tenth) / len(tenth) for tenth in tenths],
                "store_mb": [one for one in self.store_memory if one][-1],
                "map_mb": report["map_mb"], "bytes_up_mb": report["bytes_up"] / 1e6,
                "bytes_down_mb": report["bytes_down"] / 1e6, "errors": errors}


def main():
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        runs = []
        try:
            if arguments.budget != "0":
                runs.append(Run(arguments, folder, "bounded", ["--memory-budget", arguments.budget]))
            if arguments.budget == "0" or not arguments.alone:
                runs.append(Run(arguments, folder, "unbounded", []))
            while any([run.sample() for run in runs]):
                time.sleep(1)
            rows = [run.row() for run in runs]
        finally:
            for run in runs:
                run.robot.kill()
                run.store.stop()
    for row in rows:
        print(json.dumps(row))
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
