#!/usr/bin/env python3
"""Each thread that outlives the call that starts it has a name, and a row in map.md's table of threads."""

import functools
import pathlib
import re
import unittest

import rooms

ROOT = pathlib.Path(__file__).resolve().parents[2]
STARTER = "slam/util/named_thread"
STARTED = re.compile(r'\bStart(?:Thread|Async)\(\s*"([^"]+)"')
BARE = re.compile(r"\bstd::j?thread[({](?!\))|\bstd::async\((?!\s*std::launch::deferred\b)")
# Members and variables whose types are these start a thread where they are given something to run.
HOLDER = re.compile(r"\bstd::(?:vector<std::)?j?thread>? (\w+)[;{]")
# The row of loops that share one call's work among processors.
HELPERS = "helpers that end before the call returns"


@functools.cache
def sources():
    """Texts by the files' names without their suffixes; what drivers of others build with is not among them."""
    found = {}
    for path in (path for files in rooms.sources_of(ROOT).values() for path in files):
        stem = path.relative_to(ROOT).with_suffix("").as_posix()
        if path.suffix in (".cc", ".h") and not stem.endswith("_test") and "/push_client/" not in stem:
            found[stem] = found.get(stem, "") + path.read_text(encoding="utf-8")
    return found


def rows():
    """The table's first two columns: what a thread is, and the files without their suffixes."""
    page = (ROOT / "docs/map.md").read_text(encoding="utf-8")
    table = page.split("## Threads and locks")[1].split("\n## ")[0]
    short = re.findall(r"`([\w.]+/)` is `([\w./]+/)`", page)
    for what, where in re.findall(r"^\| ([^|]+) \| ([^|]+) \|", table, re.M):
        files = re.findall(r"`([\w./]+)\.(?:cc|h)\b", where)
        for shortened, folder in short:
            files = [re.sub(f"^{re.escape(shortened)}", folder, file) for file in files]
        yield what, files


def bare_starts(text):
    """What starts a thread without a name, of the text of a header and its source together."""
    found = [text[match.start():].split("\n")[0] for match in BARE.finditer(text)]
    for holder in sorted(set(HOLDER.findall(text))):
        start = re.compile(rf"\b{holder}[({{]\s*[\[&]|\b{holder}\.emplace_back\(")
        found += [text[match.start():].split("\n")[0] for match in start.finditer(text)]
    return found


class ThreadsTest(unittest.TestCase):
    maxDiff = None  # All threads that are missing are shown.

    def test_each_named_thread_has_a_row_with_its_file(self):
        started = {(name, stem) for stem, text in sources().items()
                   for name in STARTED.findall(text)}
        self.assertGreater(len(started), 45)
        rows_of = [(name, files) for what, files in rows() for name in re.findall(r"`([^`]+)`", what)]
        self.assertEqual(sorted({name for name, _ in started}), sorted(name for name, _ in rows_of))
        missing = [(name, stem) for name, stem in started if stem not in dict(rows_of)[name]]
        self.assertEqual([], missing)

    def test_no_other_thread_is_started(self):
        bare = {stem: found for stem, text in sources().items()
                if stem != STARTER and (found := bare_starts(text))}
        helpers = dict(rows())[HELPERS]
        self.assertEqual({}, {stem: found for stem, found in bare.items() if stem not in helpers})
        self.assertEqual(sorted(helpers), sorted(bare), "helpers that start none")

    def test_a_thread_without_a_name_is_found(self):
        for text in ("thread_ = std::thread([this] { Run(); });", "std::jthread{Run}.detach();",
                     "look_ = std::async(std::launch::async, Look);", "std::async(policy, [&] {})",
                     "std::thread reader_;\nA::A() : reader_([this] { Read(); }) {}",
                     "std::thread thread_;\nA::A()\n    : thread_{\n          &A::Run, this} {}",
                     "std::vector<std::thread> others;\nothers.emplace_back(run, 1);"):
            with self.subTest(text):
                self.assertEqual(1, len(bare_starts(text)))

    def test_what_starts_none_is_not_found(self):
        for text in ("std::thread thread_;", "thread_ = std::thread();",
                     "std::async(std::launch::deferred, Make)", "std::this_thread::yield();",
                     'std::thread reader_;\nreader_(StartThread("reader", [this] { Read(); }))',
                     "find_([this] { return 1; })"):
            with self.subTest(text):
                self.assertEqual([], bare_starts(text))


if __name__ == "__main__":
    unittest.main()
