#!/usr/bin/env python3
"""Each thread that outlives the call that starts it has a name, and a row in map.md's table of threads."""

import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROOMS = ("slam", "client_agent", "map_store", "fusion_worker", "services")
STARTED = re.compile(r'StartThread\(\s*"([^"]+)"')
BARE = re.compile(r"std::j?thread\((?!\))|std::j?thread\{|\bthread_?\(\[|threads_?\.emplace_back\(")
# Loops that share one call's work among processors, and end with it.
LOOPS = ("slam/optimisation/block_schur_solver.cc", "slam/vocabulary/trainer.cc",
         "services/tool/sequence/sequence_writer.cc", "parallel_rows.cc")


def sources():
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.[ch]*")):
            name = path.relative_to(ROOT).as_posix()
            is_test = name.endswith("_test.cc") or "/testing/" in name or "/push_client/" in name
            if path.suffix in (".cc", ".h") and not is_test and not name.endswith(LOOPS):
                yield name, path.read_text(encoding="utf-8")


def named_in_the_table():
    page = (ROOT / "docs/map.md").read_text(encoding="utf-8")
    table = page.split("## Threads and locks")[1].split("\n## ")[0]
    return {name for row in re.findall(r"^\| ([^|]+) \|", table, re.M)
            for name in re.findall(r"`([^`]+)`", row)}


class ThreadsTest(unittest.TestCase):
    def test_each_named_thread_has_a_row(self):
        started = {name for _, text in sources() for name in STARTED.findall(text)}
        self.assertGreater(len(started), 25)
        self.assertEqual(sorted(started), sorted(named_in_the_table()))

    def test_no_other_thread_is_started(self):
        bare = [f"{name}: {line.strip()}" for name, text in sources()
                if name != "slam/util/named_thread.h"
                for line in text.splitlines() if BARE.search(line)]
        self.assertEqual([], bare)


if __name__ == "__main__":
    unittest.main()
