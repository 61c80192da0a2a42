#!/usr/bin/env python3
"""The pages of results are what docs/results makes; each fault that is put in is found by name."""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"


def check(docs):
    """Exit code and message of `results.py --check` of a copy of the documents."""
    done = subprocess.run([sys.executable, "-B", str(docs / "results.py"), "--check"],
                          capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


class ResultsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.docs = pathlib.Path(folder.name) / "docs"
        shutil.copytree(DOCS, self.docs)

    def change(self, name, change):
        path = self.docs / "results" / name
        table = json.loads(path.read_text(encoding="utf-8"))
        change(table)
        path.write_text(json.dumps(table), encoding="utf-8")
        return check(self.docs)

    def assert_fails(self, result, *parts):
        code, message = result
        self.assertEqual(1, code, message)
        for part in parts:
            self.assertIn(part, message)

    def test_the_pages_are_what_the_tables_make(self):
        self.assertEqual((0, ""), check(DOCS))

    def test_the_first_page_is_short(self):
        first = (DOCS / "results.md").read_text(encoding="utf-8")
        self.assertLessEqual(first.count("\n"), 120)

    def test_another_figure_is_found_by_its_line(self):
        path = self.docs / "results" / "splits_fused.json"
        figure = json.loads(path.read_text(encoding="utf-8"))["rows"][0][2]
        result = self.change("splits_fused.json", lambda table: table["rows"][0].__setitem__(2, "7.77"))
        self.assert_fails(result, "docs/results", ".md:", figure, "7.77")

    def test_a_page_written_by_hand_is_found(self):
        chapters = (f"results/{path.name}" for path in (DOCS / "results").glob("*.md"))
        names = ["results.md", *chapters]
        self.assertGreater(len(names), 5)
        for name in names:
            with self.subTest(name):
                page = self.docs / name
                made = page.read_text(encoding="utf-8")
                page.write_text(made + "And more.\n", encoding="utf-8")
                self.assert_fails(check(self.docs), f"docs/{name}:", "And more.")
                page.write_text(made, encoding="utf-8")

    def test_a_chapter_that_is_gone_is_found(self):
        (self.docs / "results/robots.md").unlink()
        self.assert_fails(check(self.docs), "docs/results/robots.md:1", "# Robots")

    def test_a_page_that_is_no_chapter_is_found(self):
        (self.docs / "results/more.md").write_text("# More\n", encoding="utf-8")
        self.assert_fails(check(self.docs), "docs/results/more.md", "no chapter")

    def test_a_number_that_stands_first_is_a_cell(self):
        def rename(page):
            page["numbers"][0]["cells"][0][1] = "fused ATE, cm"
        self.assert_fails(self.change("page.json", rename), "splits_fused.json", "fused ATE, cm")

    def test_a_row_of_a_program_has_what_a_column_names(self):
        result = self.change("fusion_by_size.json", lambda table: table["rows"][0].pop("merge_ms"))
        self.assert_fails(result, "fusion_by_size.json", "merge_ms")

    def test_a_number_is_rounded_and_scaled(self):
        def change(table):
            table["rows"][0]["merge_ms"] = 0.07777
            table["columns"][1]["scale"] = 1000
        self.assert_fails(self.change("fusion_by_size.json", change), "| 136 | 77.8 |")

    def test_a_row_has_a_cell_for_each_column(self):
        result = self.change("culling.json", lambda table: table["rows"][2].pop())
        self.assert_fails(result, "culling.json", "7 cells of 8")

    def test_a_table_says_where_it_is_from(self):
        for field in ("meaning", "command", "commit", "date", "machine"):
            with self.subTest(field):
                result = self.change("drawing.json", lambda table, f=field: table.__setitem__(f, ""))
                self.assert_fails(result, "drawing.json", field)
                shutil.copy(DOCS / "results/drawing.json", self.docs / "results")

    def test_a_commit_and_a_date_can_be_looked_up(self):
        result = self.change("drawing.json", lambda table: table.__setitem__("commit", "the last one"))
        self.assert_fails(result, "the last one")
        result = self.change("drawing.json",
                             lambda table: table.update(commit="bbf9227", date="yesterday"))
        self.assert_fails(result, "yesterday")

    def test_every_table_is_on_the_page(self):
        shutil.copy(DOCS / "results/drawing.json", self.docs / "results/forgotten.json")
        self.assert_fails(check(self.docs), "forgotten.json")

    def test_a_lab_page_is_there(self):
        result = self.change("drawing.json", lambda table: table.__setitem__("lab", "lab/none.md"))
        self.assert_fails(result, "lab/none.md")


if __name__ == "__main__":
    unittest.main()
