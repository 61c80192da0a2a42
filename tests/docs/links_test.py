#!/usr/bin/env python3
"""No link of a page leads nowhere, and one that does is found by its line."""

import pathlib
import tempfile
import unittest

import links


class LinksTest(unittest.TestCase):
    def test_every_link_leads_somewhere(self):
        pages = links.pages_of(links.ROOT)
        self.assertIn(links.ROOT / "README.md", pages)
        self.assertGreater(len(pages), 60)
        self.assertEqual([], links.find_dead_links(links.ROOT, pages))

    def find(self, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            (root / "b.md").write_text("# A title, twice\n\n# A title, twice\n", encoding="utf-8")
            page = root / "a.md"
            page.write_text(text, encoding="utf-8")
            return links.find_dead_links(root, [page])

    def test_names_the_line_of_a_missing_page(self):
        self.assertEqual(["a.md:3: there is no c.md"], self.find("[b](b.md)\n\n[c](c.md)\n"))

    def test_names_a_missing_heading(self):
        self.assertEqual(["a.md:1: b.md has no heading for #nothing"], self.find("[b](b.md#nothing)"))
        self.assertEqual(["a.md:2: a.md has no heading for #end"], self.find("# Begin\n[x](#end)"))

    def test_takes_headings_as_they_are_linked(self):
        self.assertEqual([], self.find("# Z\n[1](b.md#a-title-twice) [2](b.md#a-title-twice-1) [3](#z)"))

    def test_passes_over_code_and_what_is_elsewhere(self):
        self.assertEqual([], self.find("`[x](y.md)` [w](https://a.b/c)\n```\n[x](y.md)\n```\n"))

    def test_nothing_outside_is_linked(self):
        self.assertEqual(["a.md:1: there is no ../x"], self.find("[x](../x)"))


if __name__ == "__main__":
    unittest.main()
