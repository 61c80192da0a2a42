#!/usr/bin/env python3
"""slow_link.py --bin DIR --source SPEC --out DIR: one robot's drive over links that are too slow for it.

The robot is in a network namespace of its own, at the end of a link that the kernel's token bucket
(tc tbf) shapes both ways; map store and worker are outside. Every combination of --links and of a
budget that is set and not set is one run, at the camera's pace. While it lasts, the metrics of both
ends are read each second. Prints two tables, of how tracking and the link did, and of what was held
back when, and writes all of it to OUT/slow_link.json. Needs root, iproute2 and curl.
"""

import argparse
import contextlib
import json
import os
import re
import subprocess
import sys
import time

KINDS = ("poses", "keyframes", "points", "light_points")
STORE_ADDRESS, ROBOT_ADDRESS = "10.78.0.1", "10.78.0.2"
ROBOT_METRICS = "127.0.0.1:19466"
SAMPLE = re.compile(r"^([a-z_]+)(?:\{(.*)\})? (\S+)$")


def call(*command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


class Link:
    """Two namespaces with a cable between them; `kbps` 0: as fast as can be. Gone at its end."""

    def __init__(self, kbps):
        self.robot = f"corbslam-robot-{os.getpid()}"
        self.store = f"corbslam-store-{os.getpid()}"
        self.kbps = kbps

    def __enter__(self):
        try:
            for name in (self.robot, self.store):
                call("ip", "netns", "add", name)
                call("ip", "-n", name, "link", "set", "lo", "up")
            call("ip", "-n", self.robot, "link", "add", "name", "cable", "type", "veth", "peer", "name", "cable",
                 "netns", self.store)
            for name, address in ((self.robot, ROBOT_ADDRESS), (self.store, STORE_ADDRESS)):
                call("ip", "-n", name, "address", "add", f"{address}/24", "dev", "cable")
                call("ip", "-n", name, "link", "set", "cable", "up")
                if self.kbps:
                    call("tc", "-n", name, "qdisc", "add", "dev", "cable", "root", "tbf", "rate",
                         f"{self.kbps}kbit", "burst", "4kb", "limit", "64kb")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for name in (self.robot, self.store):
            subprocess.run(["ip", "netns", "delete", name], stderr=subprocess.DEVNULL, check=False)


def in_namespace(name, command):
    return ["ip", "netns", "exec", name, *command]


@contextlib.contextmanager
def running(name, command, folder):
    """A program, ended at the end; what it says is in FOLDER/NAME.log."""
    with open(os.path.join(folder, name + ".log"), "w", encoding="utf-8") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()


def announced(folder, name, what):
    """The address that the program says it has."""
    for _ in range(600):
        with open(os.path.join(folder, name + ".log"), encoding="utf-8") as log:
            found = re.search(what + r" (\S+:\d+)", log.read())
        if found:
            return found.group(1)
        time.sleep(0.1)
    raise SystemExit(f"{name} has not said its address; see {folder}/{name}.log")


def scrape(namespace, address):
    """{name, or name{labels}: value}; empty when nobody answers."""
    answer = subprocess.run(
        in_namespace(namespace, ["curl", "--silent", "--max-time", "5", f"http://{address}/metrics"]),
        capture_output=True, text=True, check=False)
    values = {}
    for line in answer.stdout.splitlines():
        found = SAMPLE.match(line)
        if found:
            values[found.group(1) + (f"{{{found.group(2)}}}" if found.group(2) else "")] = float(
                found.group(3))
    return values


def total(values, name):
    return sum(value for key, value in values.items() if key == name or key.startswith(name + "{"))


def sample(link, store_metrics, start):
    """What both ends say now; None once the robot says nothing more."""
    robot = scrape(link.robot, ROBOT_METRICS)
    if not robot:
        return None
    store = scrape(link.store, store_metrics)
    held = {kind: robot.get(f'corbslam_robot_held_back_items{{kind="{kind}"}}', 0) for kind in KINDS}
    waited = {kind: robot.get(f'corbslam_robot_held_back_seconds{{kind="{kind}"}}', 0)
              for kind in KINDS}
    return {
        "t": time.monotonic() - start,
        "frames": total(robot, "corbslam_robot_frames_total"),
        "held_back": held,
        "waited_s": waited,
        "outbox_batches": total(robot, "corbslam_robot_outbox_batches"),
        "outbox_bytes": total(robot, "corbslam_robot_outbox_bytes"),
        "sent_bytes": total(robot, "corbslam_robot_sent_bytes_total"),
        "robot_keyframes": total(robot, "corbslam_robot_keyframes"),
        "robot_points": total(robot, "corbslam_robot_map_points"),
        "store_keyframes": total(store, "corbslam_mission_keyframes"),
        "store_points": total(store, "corbslam_mission_map_points"),
    }


def drive(options, link, budget_kbps, folder):
    """One run; its samples and what the robot said at its end."""
    os.makedirs(folder, exist_ok=True)
    binary = lambda name: os.path.join(options.bin, name)
    with contextlib.ExitStack() as stack:
        stack.enter_context(running("worker", in_namespace(link.store, [
            binary("fusion_worker"), "--insecure", "--listen", "127.0.0.1:0"]), folder))
        worker = announced(folder, "worker", "listening on")
        stack.enter_context(running("store", in_namespace(link.store, [
            binary("map_store"), "--insecure", "--listen", f"{STORE_ADDRESS}:0", "--worker", worker,
            "--metrics-listen", "127.0.0.1:0"]), folder))
        address = announced(folder, "store", "listening on")
        store_metrics = announced(folder, "store", "metrics on")
        statistics = os.path.join(folder, "robot.json")
        command = [binary("client_agent"), "--insecure", "--source", options.source, "--server",
                   address, "--mission", "slow", "--agent", "alpha", "--pace", "sensor", "--stats",
                   statistics, "--metrics-listen", ROBOT_METRICS, "--finish", str(options.finish),
                   "--seed", "1"]
        if budget_kbps:
            command += ["--uplink-kbps", str(budget_kbps), "--downlink-kbps", str(budget_kbps)]
        start = time.monotonic()
        robot = stack.enter_context(running("robot", in_namespace(link.robot, command), folder))
        samples = []
        while robot.poll() is None:
            now = sample(link, store_metrics, start)
            if now:
                samples.append(now)
            time.sleep(max(0.0, 1 - (time.monotonic() - start) % 1))
        seconds = time.monotonic() - start
        if robot.returncode != 0:
            print(f"{folder}: the robot ended with {robot.returncode}", file=sys.stderr)
        store = scrape(link.store, store_metrics)
        with open(statistics, encoding="utf-8") as file:
            said = json.load(file)
    return {"seconds": seconds, "returncode": robot.returncode, "samples": samples, "robot": said,
            "store_keyframes": total(store, "corbslam_mission_keyframes"),
            "store_points": total(store, "corbslam_mission_map_points")}


def reached(samples, key, final, share):
    """When the store first had this share of what it has in the end."""
    for entry in samples:
        if final > 0 and entry[key] >= share * final:
            return f"{entry['t']:.0f}"
    return "end"


def print_summary(runs):
    print("| link | budget | frames tracked / dropped / lost | tracking ms: median | p99 | keyframes "
          "| MB up | drive over, s | half, all keyframes there | half, all points there | whole, s |")
    print("| --- " * 11 + "|")
    for run in runs:
        robot, samples = run["robot"], run["samples"]
        frames = robot["tracked"] + robot["lost"]
        over = next((entry["t"] for entry in samples if entry["frames"] >= frames), run["seconds"])
        cells = [run["link"], run["budget"],
                 f"{robot['tracked']} / {robot['dropped']} / {robot['lost']}",
                 f"{robot['tracking_ms']['median']:.1f}", f"{robot['tracking_ms']['p99']:.1f}",
                 str(robot["keyframes"]), f"{robot['bytes_up'] / 1e6:.2f}", f"{over:.0f}"]
        for key in ("store_keyframes", "store_points"):
            cells.append(", ".join(reached(samples, key, run[key], share) for share in (0.5, 1)))
        cells.append(f"{run['seconds']:.0f}" if run["returncode"] == 0 else "not")
        print("| " + " | ".join(cells) + " |")


def print_held_back(run, every):
    print(f"\n{run['link']}, budget {run['budget']}: what was held back, and what was there\n")
    print("| s | poses | keyframes | points | light points | batches waiting | MB up "
          "| keyframes at robot, store | points at robot, store |")
    print("| --- " * 9 + "|")
    due = 0
    for entry in run["samples"]:
        if entry["t"] < due and entry is not run["samples"][-1]:
            continue
        due = entry["t"] + every
        held = entry["held_back"]
        cells = [f"{entry['t']:.0f}", *(f"{held[kind]:.0f}" for kind in KINDS),
                 f"{entry['outbox_batches']:.0f}", f"{entry['sent_bytes'] / 1e6:.2f}",
                 f"{entry['robot_keyframes']:.0f}, {entry['store_keyframes']:.0f}",
                 f"{entry['robot_points']:.0f}, {entry['store_points']:.0f}"]
        print("| " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", required=True, help="folder of the programs")
    parser.add_argument("--source", required=True, help="as client_agent takes it")
    parser.add_argument("--out", required=True, help="folder for logs and results")
    parser.add_argument("--links", default="0,1000,256", help="kbit/s, 0: not shaped")
    parser.add_argument("--budgets", default="unset,set", help="which of the two")
    parser.add_argument("--share", type=float, default=0.9,
                        help="of the link's rate that the budget is: the rest is the protocols' own")
    parser.add_argument("--finish", type=float, default=3600, help="client_agent's --finish")
    parser.add_argument("--every", type=float, default=10, help="seconds between printed rows")
    options = parser.parse_args()
    runs = []
    for kbps in (int(text) for text in options.links.split(",")):
        for budget in options.budgets.split(","):
            if budget not in ("set", "unset"):
                parser.error(f"--budgets: {budget} is neither set nor unset")
            if kbps == 0 and budget == "set":
                continue
            budget_kbps = int(options.share * kbps) if budget == "set" else 0
            name = f"{kbps}_{budget}"
            with Link(kbps) as link:
                run = drive(options, link, budget_kbps, os.path.join(options.out, name))
            run["link"] = f"{kbps} kbit/s" if kbps else "not shaped"
            run["budget"] = str(budget_kbps) if budget_kbps else "none"
            runs.append(run)
            print_held_back(run, options.every)
            with open(os.path.join(options.out, "slow_link.json"), "w", encoding="utf-8") as file:
                json.dump({"source": options.source, "runs": runs}, file, indent=1)
    print()
    print_summary(runs)


if __name__ == "__main__":
    main()
