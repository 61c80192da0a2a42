#!/usr/bin/env python3
"""Every file and function that map.md and its neighbours name is there; what is not, is found."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

import names

ROOT = pathlib.Path(__file__).resolve().parents[2]


class NamesTest(unittest.TestCase):
    def test_what_the_pages_name_is_there(self):
        for name, at_least in (("map.md", 80), ("architecture.md", 80), ("terminology.md", 30)):
            with self.subTest(name):
                page = ROOT / "docs" / name
                self.assertGreaterEqual(names.count_names(page), at_least)
                self.assertEqual([], names.find_missing(ROOT, page))

    def test_the_picture_is_that_of_the_ladders(self):
        done = subprocess.run([sys.executable, "-B", str(ROOT / "docs/map_picture.py"), "--check"],
                              capture_output=True, text=True, check=False)
        self.assertEqual((0, ""), (done.returncode, done.stderr))

    def find(self, text, search=names.find_missing):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "a/b").mkdir(parents=True)
            (root / "a/b/c.cc").write_text("int Do(int x);\nint Doing = 1;  // A PoseTable.\n",
                                           encoding="utf-8")
            page = root / "page.md"
            page.write_text(text, encoding="utf-8")
            return search(root, page)

    def test_each_private_word_is_in_its_file(self):
        self.assertEqual([], names.find_absent_words(ROOT, ROOT / "docs/terminology.md"))

    def test_takes_what_is_there(self):
        self.assertEqual([], self.find("`a/b/c.cc`, `a/b/`, `a/b/c.cc:Do`, `x`, `x.h`, `--a/b`"))

    def test_names_the_line_of_a_missing_file(self):
        self.assertEqual(["page.md:3: there is no a/c.cc"], self.find("`a/b/c.cc`\n\n`a/c.cc:Do`"))

    def test_names_a_missing_folder(self):
        self.assertEqual(["page.md:1: there is no a/c/"], self.find("`a/c/`"))

    def test_names_a_missing_function(self):
        self.assertEqual(["page.md:2: a/b/c.cc has no Doing()"], self.find("\n`a/b/c.cc:Doing`"))

    def test_a_folder_may_be_shortened(self):
        short = "`b/` is `a/b/`.\n"
        self.assertEqual([], self.find(short + "`b/c.cc:Do`"))
        self.assertEqual(["page.md:2: there is no a/b/d.cc"], self.find(short + "`b/d.cc`"))

    def test_a_word_that_is_not_in_its_file_is_found(self):
        text = ("| word | meaning | file |\n| --- | --- | --- |\n| pose table | x | `a/b/c.cc` |\n"
                "| do / doing (so) | x | `a/b/c.cc` |\n| pose, heir | x | `a/b/c.cc` |\n| do | x | |\n")
        self.assertEqual(["page.md:5: `a/b/c.cc` has no heir", "page.md:6: do names no file"],
                         self.find(text, names.find_absent_words))

    def test_passes_over_commands(self):
        self.assertEqual([], self.find("```\n`a/c.cc`\n```\n"))


if __name__ == "__main__":
    unittest.main()
