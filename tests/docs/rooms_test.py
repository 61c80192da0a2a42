#!/usr/bin/env python3
"""Every folder with sources has a line in architecture.md."""

import pathlib
import tempfile
import unittest

import rooms

ROOT = pathlib.Path(__file__).resolve().parents[2]


class RoomsTest(unittest.TestCase):
    maxDiff = None  # All lines that are missing are shown.

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name in ("a/b/c.cc", "a/b/testing/d.h", "a/e/f/g.ts", "docs/h.cc", "a/build/i.cc"):
            path = self.root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("int a;\n", encoding="utf-8")

    def page(self, text):
        page = self.root / "page.md"
        page.write_text(text, encoding="utf-8")
        return page

    def test_every_room_has_a_line(self):
        self.assertGreater(len(rooms.sources_of(ROOT)), 60)
        self.assertEqual([], rooms.find_unnamed_rooms(ROOT, ROOT / "docs/architecture.md"))

    def test_a_room_without_a_line_is_found(self):
        missing = rooms.find_unnamed_rooms(self.root, self.page("| `a/b/` | x |\n"))
        self.assertEqual(["page.md: there is no line for a/e/f/ (1 sources): "
                          "add | `a/e/f/` | what is in it |"], missing)

    def test_a_room_may_be_named_with_all_below_it(self):
        self.assertEqual([], rooms.find_unnamed_rooms(self.root, self.page("`a/b/`, `a/e/...`")))


if __name__ == "__main__":
    unittest.main()
