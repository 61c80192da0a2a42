#!/usr/bin/env python3
"""Whether a robot that joins another's poor map is worse off than alone.

In a simulated town (exact truth) a first robot drives a street with poor pictures or a wrong rig; then a
second one, with good pictures, drives a part of it in the first one's map. In lockstep, so that one run
stands for all. The errors of the second robot, its own trajectory and as told when each frame came, are
printed beside those of the same robot without a store. --keep FOLDER keeps the runs, and takes those that
are there.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

# What is wrong with the first robot, as options of its source (docs/simulation.md).
KINDS = {
    "good": "",
    "half its frames": "stride=2",
    "a third of its frames, noise": "stride=3&noise=12",
    "noise": "noise=15",
    "blur": "blur_px=1.5&noise=4",
    "disparities 0.3 px too small": "disparity_error_px=0.3",
    "baseline 1 % too long": "scale_error=0.01",
    "baseline 2 % too long": "scale_error=0.02",
}


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--seeds", default="7,8,9", help="towns, by commas")
    parser.add_argument("--kinds", help="some of the kinds, by semicolons")
    parser.add_argument("--keep", help="folder for the runs")
    parser.add_argument("--json", help="file for the table")
    return parser.parse_args()


def play(arguments, out, *flags):
    """Returns the run's report; plays it where the folder does not have it yet."""
    report = out / "report.json"
    if not report.exists():
        subprocess.run([f"{arguments.bin}/corbslam", "run", "--pace", "step", *flags, "--out", str(out)],
                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=True)
    return json.loads(report.read_text())


def sources(seed, kind):
    town = f"sim:city?seed={seed}&length=300"
    first = f"{town}&frames=0:300" + ("&" + KINDS[kind] if KINDS[kind] else "")
    return first, f"{town}&frames=80:260&phase=0.5&noise_seed={seed + 20}"


def errors(report, name):
    """Returns the robot's own error and that of what it told, metres; None where there is none."""
    robot = next(robot for robot in report["robots"] if robot["name"] == name)
    return robot["ate_m"], robot["told"]["ate_m"]


def cell(value, beside):
    if value is None:
        return "-"
    return f"{value:.4f} ({value / beside:.2f})" if beside else f"{value:.4f}"


def row(arguments, folder, seed, kind, alone):
    first, second = sources(seed, kind)
    name = f"{seed}-{list(KINDS).index(kind)}"
    report = play(arguments, folder / name, "--sequential", "--source", first, "--source", second)
    own, told = errors(report, "bravo")
    said = [w for w in report["warnings"] if w["code"] in ("others-distances", "others-shape")]
    return [kind, str(seed), cell(errors(report, "alpha")[0], None), cell(own, alone[0]), cell(told, alone[1]),
            str(report["fused"]["islands"]), "yes" if said else "no"]


def main():
    arguments = parse_arguments()
    kinds = arguments.kinds.split(";") if arguments.kinds else list(KINDS)
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        sys.exit(f"late_joiner: no kind {unknown[0]!r}; there are: {'; '.join(KINDS)}")
    columns = ["the first robot", "town", "its map, m", "the joiner's own, m (of alone)",
               "as told, m (of alone)", "islands", "says so"]
    rows = []
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(arguments.keep or made)
        folder.mkdir(parents=True, exist_ok=True)
        print("| " + " | ".join(columns) + " |", flush=True)
        print("| " + " | ".join("---" for _ in columns) + " |", flush=True)
        for seed in (int(text) for text in arguments.seeds.split(",")):
            by_itself = play(arguments, folder / f"{seed}-alone", "--robots", "1", "--source", sources(seed, "good")[1])
            alone = errors(by_itself, "alpha")
            rows.append(["(alone)", str(seed), "-", cell(alone[0], None), cell(alone[1], None), "1", "-"])
            print("| " + " | ".join(rows[-1]) + " |", flush=True)
            for kind in kinds:
                rows.append(row(arguments, folder, seed, kind, alone))
                print("| " + " | ".join(rows[-1]) + " |", flush=True)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps({"columns": columns, "rows": rows}, indent=2))


if __name__ == "__main__":
    main()
