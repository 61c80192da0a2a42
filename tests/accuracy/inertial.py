#!/usr/bin/env python3
"""What an IMU gives a robot whose pictures fail it.

Plays simulated flights to one robot each, in lockstep, once without an IMU and once with each of --imus:
undisturbed, with blackouts of one and three seconds, from a dark and from a still start, and with fast
turns. --measured FOLDER adds the flight of a real IMU (body.tum: its poses; imu.csv: what it measured, in
EuRoC's form), its pictures drawn in a room. Prints, and writes with --json, for each: the error of the
trajectory at the end and of the poses as told when each frame came (RMSE, metres), local maps, frames
tracked and lost. Programs are found in --bin.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

FLIGHT = "sim:floor?motion=fly&rig=euroc"
NO_SAMPLES = "imu_gaps=0:1000000"  # The pictures of a real IMU's flight, without what it measured.


def parse_arguments():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--bin", default=str(root / "build/release/bin"))
    parser.add_argument("--imus", default="ideal,good,phone", help="beside none, with commas between")
    parser.add_argument("--worlds", default="2,5", help="seeds of the floors, with commas between")
    parser.add_argument("--frames", type=int, default=600, help="of each flight, 20 a second")
    parser.add_argument("--options", default="", help="of every source, for example picture_scale=0.5")
    parser.add_argument("--only", default="", help="flights whose name has this")
    parser.add_argument("--measured", help="folder with body.tum and imu.csv")
    parser.add_argument("--json", help="file for the results")
    arguments = parser.parse_args()
    if arguments.frames < 300:
        parser.error("--frames: give at least 300, so that something comes after a blackout")
    return arguments


def turn_fast(path):
    """Writes a camera's poses: rounds in a room of 3 x 2 m, looking left and right at up to 3 rad/s."""
    lines = []
    for i in range(6000):
        t = 0.01 * i
        yaw = 1.5 * math.sin(2 * t) + 0.5 * t
        place = (1.5 * math.sin(0.5 * t), -0.3 * math.sin(0.7 * t), math.sin(t))
        lines.append(" ".join(f"{value:.9f}" for value in
                              (t, *place, 0, math.sin(yaw / 2), 0, math.cos(yaw / 2))))
    path.write_text("\n".join(lines) + "\n")


def flights(arguments, folder):
    """Name, source without an IMU, and whether the IMU is the flight's own."""
    found = []
    for seed in arguments.worlds.split(","):
        way = f"{FLIGHT}&seed={seed}"
        for name, options in (("undisturbed", ""), ("blackout 1 s", "&blackout=8:1"),
                              ("blackout 3 s", "&blackout=8:3"),
                              ("blackout 3 s, early", "&blackout=2:3"),
                              ("dark start", "&beginning=2:0:0&set_off_s=2"),
                              ("still start", "&beginning=0:0:2&set_off_s=2")):
            found.append((f"{name}, floor {seed}", way + options, False))
    turns = folder / "turns.tum"
    turn_fast(turns)
    for name, options in (("fast turns", ""), ("fast turns, blackout 1 s", "&blackout=8:1")):
        found.append((name, f"sim:path?rig=euroc&around=room&poses={turns}{options}", False))
    if arguments.measured:
        real = pathlib.Path(arguments.measured).resolve()
        way = f"sim:path?rig=euroc&around=room&poses={real / 'body.tum'}&imu={real / 'imu.csv'}"
        for name, options in (("real IMU", ""), ("real IMU, blackout 1 s", "&blackout=8:1"),
                              ("real IMU, blackout 3 s", "&blackout=8:3")):
            found.append((name, way + options, True))
    return [flight for flight in found if arguments.only in flight[0]]


def play(arguments, source, folder):
    """The report of a run, or what it said instead."""
    out = folder / "out"
    command = [f"{arguments.bin}/corbslam", "run", "--pace", "step", "--robots", "1", "--source", source,
               "--out", str(out)]
    report = out / "report.json"
    report.unlink(missing_ok=True)
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0 or not report.exists():
        return None, " ".join((done.stderr.strip().splitlines() or ["no report"])[-1:])
    return json.loads(report.read_text()), ""


def row_of(arguments, flight, imu, folder):
    name, source, is_measured = flight
    parts = [source, f"frames=0:{arguments.frames - 1}", arguments.options]
    if imu == "none":
        parts.append(NO_SAMPLES if is_measured else "imu=0")
    elif not is_measured:
        parts.append(f"imu={imu}")
    source = "&".join(part for part in parts if part)
    report, failure = play(arguments, source, folder)
    row = {"flight": name, "imu": imu, "source": source}
    if report is None:
        return {**row, "failed": failure}
    robot = report["robots"][0]
    return {**row, "version": report["version"], "ate_m": robot["ate_m"],
            "told_ate_m": (robot.get("told") or {}).get("ate_m"), "local_maps": robot["local_maps"],
            "frames": robot["frames"], "tracked": robot["tracked"], "lost": robot["lost"]}


def commit_of():
    root = pathlib.Path(__file__).resolve().parent
    done = subprocess.run(["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=12"],
                          capture_output=True, text=True, check=False)
    return done.stdout.strip() or None


def print_row(row):
    if "failed" in row:
        print(f"{row['flight']:<32}{row['imu']:<10}failed: {row['failed']}", flush=True)
        return
    errors = "".join(f"{'-' if row[key] is None else format(row[key], '.3f'):>10}"
                     for key in ("ate_m", "told_ate_m"))
    print(f"{row['flight']:<32}{row['imu']:<10}{errors}{row['local_maps']:>6}{row['tracked']:>9}"
          f"{row['lost']:>6}", flush=True)


def print_means(rows, imus):
    """Of the flights that every IMU, and none, finished with an error."""
    by_flight = {}
    for row in rows:
        by_flight.setdefault(row["flight"], {})[row["imu"]] = row
    for imu in imus:
        both = [(found["none"], found[imu]) for found in by_flight.values()
                if imu in found and all(row.get("ate_m") is not None
                                        for row in (found["none"], found[imu]))]
        if both:
            means = [statistics.mean(pair[i]["ate_m"] for pair in both) for i in (0, 1)]
            print(f"{len(both)} flights, error without and with {imu}: {means[0]:.3f} {means[1]:.3f} m;"
                  f" lost {sum(pair[0]['lost'] for pair in both)} and"
                  f" {sum(pair[1]['lost'] for pair in both)}")


def main():
    arguments = parse_arguments()
    imus = arguments.imus.split(",")
    result = {"commit": commit_of(), "command": " ".join(sys.argv), "rows": []}
    print(f"{'flight':<32}{'imu':<10}{'ate m':>10}{'told m':>10}{'maps':>6}{'tracked':>9}{'lost':>6}")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for flight in flights(arguments, folder):
            for imu in ["none", *(["own"] if flight[2] else imus)]:
                result["rows"].append(row_of(arguments, flight, imu, folder))
                print_row(result["rows"][-1])
                # What was measured is kept if a later flight fails.
                if arguments.json:
                    pathlib.Path(arguments.json).write_text(json.dumps(result, indent=2))
    print_means(result["rows"], [*imus, "own"])


if __name__ == "__main__":
    main()
