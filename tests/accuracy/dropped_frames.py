#!/usr/bin/env python3
"""What a robot loses where frames are dropped, as by a processor that is short of time.

Plays a sequence in KITTI's layout to one robot, in lockstep, without frames that chance takes out: after a
share of the frames, one to three are missing. Prints, and writes with --json, the error of the robot's
own trajectory (RMSE, metres) for each share and seed. Without --sequence, a simulated drive is written
first. Programs are found in --bin.
"""
import argparse
import json
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile

from kitti_folder import link_frames


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--sequence", help="folder in KITTI's layout, with poses.txt")
    parser.add_argument("--drive", default="sim:city?seed=7&length=400&picture_scale=0.5&frames=0:249")
    parser.add_argument("--shares", default="0,0.15,0.3")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--json", help="file for the results")
    return parser.parse_args()


def run(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr)


def choose(count, share, seed):
    chance = random.Random(seed)
    kept, i = [], 0
    while i < count:
        kept.append(i)
        i += 1 + (chance.choice((1, 1, 2, 3)) if chance.random() < share else 0)
    return kept


def leave_out(sequence, kept, folder):
    link_frames(sequence, kept, folder)
    for name in ("times.txt", "poses.txt"):
        lines = (sequence / name).read_text().splitlines()
        (folder / name).write_text("".join(f"{lines[i]}\n" for i in kept))


def error_of(arguments, sequence, kept, folder):
    leave_out(sequence, kept, folder / "sequence")
    run(f"{arguments.bin}/corbslam", "run", "--pace", "step", "--robots", "1", "--source",
        f"kitti:{folder / 'sequence'}", "--out", str(folder / "out"))
    return json.loads((folder / "out" / "report.json").read_text())["robots"][0]["ate_m"]


def main():
    arguments = parse_arguments()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        sequence = pathlib.Path(arguments.sequence or f"{name}/drive").resolve()
        if not arguments.sequence:
            run(f"{arguments.bin}/corbslam", "simulate", "--source", arguments.drive, "--layout",
                "kitti", "--out", str(sequence))
        count = len((sequence / "times.txt").read_text().splitlines())
        for share in (float(word) for word in arguments.shares.split(",")):
            errors, played = [], []
            for seed in range(arguments.seeds if share > 0 else 1):
                kept = choose(count, share, seed)
                with tempfile.TemporaryDirectory() as folder:
                    errors.append(error_of(arguments, sequence, kept, pathlib.Path(folder)))
                played.append(len(kept))
            known = [error for error in errors if error is not None]
            rows.append({"share": share, "frames": played, "ate_m": errors})
            print(f"share {share:g}  frames {min(played)} to {max(played)} of {count}  "
                  f"ate median {statistics.median(known):.3f} least {min(known):.3f} "
                  f"most {max(known):.3f} m  without a trajectory {len(errors) - len(known)}",
                  flush=True)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
