#!/usr/bin/env python3
"""long_calls.py BIN --source SOURCE [--robots 6] [--seconds 20]: how long look-ups take beside backups, restores
and missions that are put to sleep.

BIN is the folder of programs, SOURCE what each robot maps first (docs/sources.md). Prints the times of ListMissions,
GetMission of a small mission and GetStatistics of it for 0, 2 and 8 backups of the large mission at once, 8 restores,
and 4 missions put to sleep and woken, and ends with 1 if a 99th percentile is over five times the quiet one.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

import grpc

STORE = "/corbslam.v1.MapStore/"


def field(number, text):
    """Encodes a string field of a message (below 16384 bytes), as protobuf does it."""
    data = text.encode() if isinstance(text, str) else text
    length = len(data)
    size = bytearray()
    while True:
        size.append((length & 0x7F) | (0x80 if length > 0x7F else 0))
        length >>= 7
        if not length:
            break
    return bytes([number << 3 | 2]) + bytes(size) + data


class Store:
    def __init__(self, address):
        options = [("grpc.use_local_subchannel_pool", 1), ("grpc.max_receive_message_length", 1 << 23)]
        self.channel = grpc.insecure_channel(address, options)

    def ask(self, method, request=b"", timeout=120):
        return self.channel.unary_unary(STORE + method)(request, timeout=timeout)

    def backup(self, mission):
        """Returns the pieces, each as the message that brought it."""
        return list(self.channel.unary_stream(STORE + "BackupMission")(field(1, f"missions/{mission}"), timeout=300))

    def restore(self, mission, pieces):
        # BackupMissionResponse.piece is field 1, RestoreMissionRequest.name 1 and .piece 2.
        def requests():
            for number, piece in enumerate(pieces):
                yield (field(1, f"missions/{mission}") if number == 0 else b"") + bytes([2 << 3 | 2]) + piece[1:]
        self.channel.stream_unary(STORE + "RestoreMission")(requests(), timeout=300)


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))]


class Load:
    """Does something again and again, so many times at once."""

    def __init__(self, address, doings):
        self.stop = threading.Event()
        self.done = 0
        self.failed = {}
        self.threads = [threading.Thread(target=self.run, args=(Store(address), do)) for do in doings]

    def run(self, store, do):
        # Whoever asks for so much is elsewhere: what it takes here is not the store's.
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 19)
        while not self.stop.is_set():
            try:
                do(store)
                self.done += 1
            except grpc.RpcError as error:
                self.failed[error.code().name] = self.failed.get(error.code().name, 0) + 1
                time.sleep(0.1)

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.stop.set()
        for thread in self.threads:
            thread.join()


def look_ups(address, seconds):
    """Runs measure in a process of its own: the load's threads here hold Python's lock for milliseconds."""
    measured = subprocess.run([sys.executable, __file__, ".", "--source", "", "--seconds", str(seconds), "--measure", address],
                              stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(measured.stdout)


def measure(address, seconds):
    store = Store(address)
    asks = {"ListMissions": b"", "GetMission": field(1, "missions/small"), "GetStatistics": field(1, "missions/small")}
    times = {method: [] for method in asks}
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for method, request in asks.items():
            begin = time.monotonic()
            store.ask(method, request)
            times[method].append((time.monotonic() - begin) * 1e3)
        time.sleep(0.02)
    return times


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--source", required=True)
    parser.add_argument("--robots", type=int, default=6)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--measure", metavar="ADDRESS", help="only measure look-ups there")
    flags = parser.parse_args()
    if flags.measure:
        print(json.dumps(measure(flags.measure, flags.seconds)))
        return 0
    programs = pathlib.Path(flags.folder)
    bad = []
    with tempfile.TemporaryDirectory() as data:
        server = subprocess.Popen([programs / "map_store", "--insecure", "--listen", "127.0.0.1:0", "--data-dir", f"{data}/store"],
                                  stdout=subprocess.PIPE, stderr=open(f"{data}/store.log", "w"), text=True)
        address = server.stdout.readline().split()[-1]
        robots = [subprocess.Popen([programs / "client_agent", "--insecure", "--server", address, "--mission", mission,
                                    "--agent", f"r{number}", "--source", flags.source, "--features", features, "--finish", "60"],
                                   stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
                  for mission, count, features in (("big", flags.robots, "4000"), ("small", 1, "500")) for number in range(count)]
        for robot in robots:
            robot.wait()
        store = Store(address)
        pieces = store.backup("big")
        for number in range(4):
            store.restore(f"sleeper{number}", store.backup("small"))
        print(f"the large mission's backup: {sum(map(len, pieces)) / 1e6:.0f} MB\n")

        def restore(number):
            def do(caller):
                caller.restore(f"restored{number}", pieces)
                caller.ask("DeleteMission", field(1, f"missions/restored{number}"))
            return do

        def sleep(number):
            def do(caller):
                caller.ask("SleepMission", field(1, f"missions/sleeper{number}"))
                caller.ask("ListLocalMaps", field(1, f"missions/sleeper{number}"))
            return do

        backup = lambda caller: caller.backup("big")
        loads = {"nothing": [], "2 backups": [backup] * 2, "8 backups": [backup] * 8,
                 "8 restores": [restore(n) for n in range(8)], "4 missions put to sleep": [sleep(n) for n in range(4)]}
        quiet = None
        print("| beside | ListMissions p50, p99 ms | GetMission | GetStatistics | done | failed |\n| --- | --- | --- | --- | --- | --- |")
        for name, doings in loads.items():
            with Load(address, doings) as load:
                time.sleep(1)
                times = look_ups(address, flags.seconds)
            cells = [f"{percentile(t, 0.5):.1f}, {percentile(t, 0.99):.1f}" for t in times.values()]
            print(f"| {name} | {' | '.join(cells)} | {load.done} | {load.failed or ''} |", flush=True)
            quiet = quiet or times
            for method, taken in times.items():
                if percentile(taken, 0.99) > 5 * percentile(quiet[method], 0.99):
                    bad.append(f"{method} beside {name}: {percentile(taken, 0.99):.1f} ms, quiet "
                               f"{percentile(quiet[method], 0.99):.1f}")
        server.terminate()
        server.wait()
    for one in bad:
        print("BAD", one)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
