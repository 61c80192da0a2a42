#!/usr/bin/env python3
"""idle_connections.py BIN --source SOURCE [--connections 10000] [--seconds 60]: opens idle connections to every
port of a store, a worker, a viewer and a robot, and says how robots, probes and pages fare meanwhile.

BIN is the folder of programs, SOURCE what a robot plays (docs/sources.md), again and again.
The connections come from 127.0.0.1 to 127.0.0.3 to each port; those that a server ends are opened anew, up to
--reopen a second and port. Every probe is a connection of its own. Prints a table and ends with 1 if a probe was
not answered, if a 99th percentile is over twice the quiet one (and over 50 ms), or if memory did not come back.
"""

import argparse
import multiprocessing
import pathlib
import re
import resource
import select
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

import grpc

HOSTS = ("127.0.0.1", "127.0.0.2", "127.0.0.3")
# Words by which a connection begins and goes no further; silent ones alone would never reach gRPC.
WORDS = (b"", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", b"G")


def idle_socket(port, number):
    made = socket.socket()
    made.setblocking(False)
    made.bind((HOSTS[number % 3], 0))
    made.connect_ex(("127.0.0.1", port))
    return made


def crowd(port, count, reopen, stop, opened):
    """Keeps `count` connections open until `stop`."""
    poll = select.epoll()
    sockets = {}

    def add(number):
        made = idle_socket(port, number)
        sockets[made.fileno()] = (made, number)
        poll.register(made.fileno(), select.EPOLLIN | select.EPOLLOUT | select.EPOLLRDHUP | select.EPOLLONESHOT)

    missing = list(range(count))
    allowance = float(reopen)
    last = time.monotonic()
    while not stop.is_set():
        now = time.monotonic()
        allowance = min(float(reopen), allowance + (now - last) * reopen)
        last = now
        while missing and allowance >= 1:
            add(missing.pop())
            opened.value += 1
            allowance -= 1
        for fd, events in poll.poll(0.05):
            made, number = sockets[fd]
            if events & (select.EPOLLRDHUP | select.EPOLLHUP | select.EPOLLERR):
                poll.unregister(fd)
                made.close()
                del sockets[fd]
                missing.append(number)
                continue
            try:
                if events & select.EPOLLOUT:
                    made.send(WORDS[number // 3 % 3])
                elif events & select.EPOLLIN:
                    made.recv(4096)
                poll.modify(fd, select.EPOLLIN | select.EPOLLRDHUP | select.EPOLLONESHOT)
            except OSError:
                pass


def ask_grpc(port, method):
    options = [("grpc.use_local_subchannel_pool", 1)]
    with grpc.insecure_channel(f"127.0.0.1:{port}", options) as channel:
        channel.unary_unary(method)(b"", timeout=10)


def ask_http(port, path):
    urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=10).read()


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


def resident_mb(process):
    text = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) / 1024


def histogram(port, name):
    text = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=10).read().decode()
    counts = {}
    for bound, count in re.findall(rf'^{name}_bucket\{{[^}}]*le="([^"]+)"\}} (\S+)$', text, re.MULTILINE):
        counts[float(bound)] = counts.get(float(bound), 0) + float(count)
    return counts


def quantile(before, after, share):
    counts = [(bound, after[bound] - before.get(bound, 0)) for bound in sorted(after)]
    total = counts[-1][1] if counts else 0
    low, below = 0.0, 0
    for bound, count in counts:
        if total and count >= share * total:
            return low + (min(bound, 1e9) - low) * (share * total - below) / max(count - below, 1e-9)
        low, below = bound, count
    return float("nan")


class Programs:
    def __init__(self, folder, data, source):
        self.folder = pathlib.Path(folder)
        self.data = data
        self.all = {}
        self.ports = {}
        store = ("--insecure", "--listen", "127.0.0.1:0", "--metrics-listen", "127.0.0.1:0")
        self.start("fusion_worker", *store)
        self.start("map_store", *store, "--data-dir", f"{data}/store", "--worker", f"127.0.0.1:{self.ports['fusion_worker'][0]}")
        server = f"127.0.0.1:{self.ports['map_store'][0]}"
        self.server, self.source, self.drives = server, source, 0
        self.start("map_viewer", *store, "--store", server, "--page", f"{data}/nowhere")
        self.start("client_agent", "--insecure", "--server", server, "--mission", "m", "--agent", "a", "--source", source,
                   "--listen", "127.0.0.1:0", "--metrics-listen", "127.0.0.1:0", "--stay")

    def start(self, name, *flags):
        process = subprocess.Popen([self.folder / name, *flags], stdout=subprocess.PIPE,
                                   stderr=open(f"{self.data}/{name}.log", "w"), text=True)
        self.all[name] = process
        metrics = None
        for line in process.stdout:
            if line.startswith("metrics on "):
                metrics = int(line.rsplit(":", 1)[1])
            if line.startswith("listening on "):
                self.ports[name] = (int(line.rsplit(":", 1)[1]), metrics)
                return
        sys.exit(f"{name} did not start; see {self.data}/{name}.log")

    def drive(self):
        """Starts a robot of a new name, which plays the source once."""
        self.drives += 1
        return subprocess.Popen([self.folder / "client_agent", "--insecure", "--server", self.server, "--mission", "m", "--agent",
                                 f"drive{self.drives}", "--source", self.source], stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)

    def stop(self):
        for process in self.all.values():
            process.terminate()
        for process in self.all.values():
            process.wait()


def probes_of(programs):
    store, store_metrics = programs.ports["map_store"]
    worker, worker_metrics = programs.ports["fusion_worker"]
    viewer, viewer_metrics = programs.ports["map_viewer"]
    robot, robot_metrics = programs.ports["client_agent"]
    check = "/grpc.health.v1.Health/Check"
    return {
        "store: health": lambda: ask_grpc(store, check),
        "store: ListMissions": lambda: ask_grpc(store, "/corbslam.v1.MapStore/ListMissions"),
        "store: metrics": lambda: ask_http(store_metrics, "/metrics"),
        "worker: health": lambda: ask_grpc(worker, check),
        "worker: metrics": lambda: ask_http(worker_metrics, "/metrics"),
        "viewer: /healthz": lambda: ask_http(viewer, "/healthz"),
        "viewer: /api/missions": lambda: ask_http(viewer, "/api/missions"),
        "viewer: metrics": lambda: ask_http(viewer_metrics, "/metrics"),
        "robot: health": lambda: ask_grpc(robot, check),
        "robot: metrics": lambda: ask_http(robot_metrics, "/metrics"),
    }


def measure(programs, seconds):
    """Returns each probe's times in ms and failures, and the robot's 99th percentile of acknowledgements."""
    name = "corbslam_acknowledgement_duration_seconds"
    metrics = programs.ports["map_store"][1]
    before = histogram(metrics, name)
    times = {probe: [] for probe in probes_of(programs)}
    failures = {probe: 0 for probe in times}
    robot = programs.drive()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if robot.poll() is not None:
            robot = programs.drive()
        for probe, ask in probes_of(programs).items():
            begin = time.monotonic()
            try:
                ask()
                times[probe].append((time.monotonic() - begin) * 1e3)
            except (OSError, grpc.RpcError):
                failures[probe] += 1
        time.sleep(0.05)
    robot.terminate()
    robot.wait()
    return times, failures, quantile(before, histogram(metrics, name), 0.99) * 1e3


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--source", required=True)
    parser.add_argument("--connections", type=int, default=10000)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--reopen", type=int, default=500)
    flags = parser.parse_args()
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    bad = []
    with tempfile.TemporaryDirectory() as data:
        programs = Programs(flags.folder, data, flags.source)
        time.sleep(3)
        quiet, _, quiet_ack = measure(programs, flags.seconds)
        rss_before = {name: resident_mb(process) for name, process in programs.all.items()}
        stop = multiprocessing.Event()
        opened = multiprocessing.Value("L", 0)
        crowds = [multiprocessing.Process(target=crowd, args=(port, flags.connections, flags.reopen, stop, opened))
                  for ports in programs.ports.values() for port in ports]
        for one in crowds:
            one.start()
        # Each is to have opened as many as it wants.
        time.sleep(min(30, flags.connections / flags.reopen))
        crowded, failures, crowded_ack = measure(programs, flags.seconds)
        rss_during = {name: resident_mb(process) for name, process in programs.all.items()}
        stop.set()
        for one in crowds:
            one.join()
        time.sleep(15)
        after, after_failures, _ = measure(programs, 5)
        print(f"{flags.connections} connections to each of {len(crowds)} ports, {opened.value} opened in all\n")
        print("| probe | quiet p50, p99 ms | crowded p50, p99 ms | not answered | after p99 ms |\n| --- | --- | --- | --- | --- |")
        for probe, times in quiet.items():
            p99 = percentile(times, 0.99), percentile(crowded[probe], 0.99)
            print(f"| {probe} | {percentile(times, 0.5):.1f}, {p99[0]:.1f} | {percentile(crowded[probe], 0.5):.1f}, {p99[1]:.1f} "
                  f"| {failures[probe]} of {failures[probe] + len(crowded[probe])} | {percentile(after[probe], 0.99):.1f} |")
            if failures[probe] or after_failures[probe]:
                bad.append(f"{probe}: not answered")
            if p99[1] > max(2 * p99[0], 50):
                bad.append(f"{probe}: {p99[1]:.0f} ms instead of {p99[0]:.0f}")
        print(f"| acknowledgements | p99 {quiet_ack:.1f} | p99 {crowded_ack:.1f} | | |\n")
        if crowded_ack > max(2 * quiet_ack, 50):
            bad.append(f"acknowledgements: {crowded_ack:.0f} ms instead of {quiet_ack:.0f}")
        print("| program | MB before | with the crowd | after |\n| --- | --- | --- | --- |")
        for name, process in programs.all.items():
            end = resident_mb(process)
            print(f"| {name} | {rss_before[name]:.0f} | {rss_during[name]:.0f} | {end:.0f} |")
        programs.stop()
    for one in bad:
        print("BAD", one)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
