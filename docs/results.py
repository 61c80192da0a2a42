#!/usr/bin/env python3
"""Makes docs/results.md and its chapters of the tables in docs/results, or checks what they make.

  docs/results.py           writes docs/results.md and docs/results/CHAPTER.md
  docs/results.py --check   fails, with the first line that differs, where a page is another one

page.json holds the first page's beginning, the numbers that stand first (a sentence with {} for
each of its cells of a table: [row, title of the column]), the chapters and what was not measured.
Every other file is a table: title, what it means, command, commit, date, machine, columns, rows, and,
where there is one, the lab page with the way there. A column is a title, with rows of cells in the
same order; or {"title", "key", "digits", "scale"}, with rows as a program writes them as JSON, of
which the key is taken ("quiet.p99_ms": p99_ms inside quiet), times the scale. Links in these files
are as seen from docs/. README's `tests/run.sh` runs the check (docs.results).
"""

import datetime
import json
import pathlib
import re
import sys

DOCS = pathlib.Path(__file__).resolve().parent
# The command of a table whose rows each name one.
IN_ROWS = "as in the rows"
MADE = "<!-- Made by docs/results.py of docs/results; change those, not this. -->"
TEXTS = ("title", "meaning", "command", "commit", "date", "machine")


class Invalid(Exception):
    """Names the file, the field and what is wrong with it."""


def require(holds, name, what):
    if not holds:
        raise Invalid(f"docs/results/{name}: {what}")


def read(folder, name):
    try:
        value = json.loads((folder / name).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise Invalid(f"docs/results/{name}: {error}") from error
    require(isinstance(value, dict), name, "is no object")
    return value


def number(value, digits):
    return f"{value:,.{digits}f}" if digits is not None else f"{value:,}"


def keyed_cell(row, column, name):
    value = row
    for part in column["key"].split("."):
        require(isinstance(value, dict) and part in value, name,
                f"rows: one has no {column['key']}")
        value = value[part]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return number(value * column.get("scale", 1), column.get("digits"))
    require(isinstance(value, str), name, f"rows: {column['key']} is no text and no number")
    return value


def cells(table, name):
    """The table's rows as texts."""
    columns = table["columns"]
    for row in table["rows"]:
        if isinstance(row, dict):
            require(all(isinstance(c, dict) for c in columns), name,
                    "columns: rows are objects, but not every column has a key")
            yield [keyed_cell(row, column, name) for column in columns]
            continue
        require(len(row) == len(columns), name,
                f"rows: {row} has {len(row)} cells of {len(columns)}")
        require(all(isinstance(cell, str) for cell in row), name, f"rows: {row} is not all text")
        yield row


def check(table, name):
    for field in TEXTS:
        require(isinstance(table.get(field), str) and table[field], name, f"{field}: is missing")
    require(re.search(r"\b[0-9a-f]{7}\b", table["commit"]), name,
            f"commit: {table['commit']} names none")
    try:
        datetime.date.fromisoformat(table["date"])
    except ValueError as error:
        raise Invalid(f"docs/results/{name}: date: {error}") from error
    require(table.get("columns") and table.get("rows"), name, "columns or rows: are missing")


def line(texts):
    return "| " + " | ".join(text.replace("\n", " ") for text in texts) + " |"


def render(table, name, docs):
    check(table, name)
    titles = [c["title"] if isinstance(c, dict) else c for c in table["columns"]]
    lines = [f"## {table['title']}", "", table["meaning"], "", line(titles),
             line(["---"] * len(titles))]
    lines += [line(row) for row in cells(table, name)]
    command = table["command"]
    source = "Commands" if command == IN_ROWS else f"`{command}`"
    source += f" at {table['commit']}; {table['date']}, {table['machine']}"
    if "lab" in table:
        require((docs / table["lab"]).is_file(), name, f"lab: there is no docs/{table['lab']}")
        source += f"; [more]({table['lab']})"
    return lines + ["", source + f" ([{name}](results/{name})).", ""]


def anchor(title):
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def chapter_of(page, name):
    for chapter in page["chapters"]:
        if name in chapter["tables"]:
            return chapter["file"]
    raise Invalid(f"docs/results/page.json: numbers: {name} is in no chapter")


def first_numbers(page, folder):
    lines = ["## In short", ""]
    for number_of in page["numbers"]:
        name = number_of["table"]
        table = read(folder, name)
        titles = [c["title"] if isinstance(c, dict) else c for c in table["columns"]]
        rows = list(cells(table, name))
        values = []
        for row, title in number_of["cells"]:
            require(title in titles and row < len(rows), "page.json",
                    f"numbers: {name} has no row {row} with '{title}'")
            values.append(f"**{rows[row][titles.index(title)]}**")
        said = number_of["says"]
        require(said.count("{}") == len(values), "page.json",
                f"numbers: '{said}' has not as many places as cells")
        link = f"results/{chapter_of(page, name)}#{anchor(table['title'])}"
        lines.append(f"* {said.format(*values)} ([more]({link}))")
    return lines + [""]


def chapter_list(page, folder):
    """A line for each chapter, and below it one for each table."""
    lines = ["## Chapters", ""]
    for chapter in page["chapters"]:
        file = f"results/{chapter['file']}"
        lines.append(f"* [{chapter['title']}]({file}): {chapter['says']}")
        for name in chapter["tables"]:
            title = read(folder, name)["title"]
            lines.append(f"  * [{title}]({file}#{anchor(title)})")
    return lines + [""]


def seen_from_results(text):
    """Links as seen from docs/ become links as seen from docs/results/."""
    text = re.sub(r"\]\((?![a-z]+:|#)", "](../", text)
    return text.replace("](../results/", "](")


def make_chapter(chapter, docs):
    lines = [f"# {chapter['title']}", "", MADE, "", f"{chapter['says']} "
             "ATE, `DATA`, `KITTI`, `TUM` and `RUN`: see [results.md](results.md).", ""]
    for name in chapter["tables"]:
        lines += render(read(docs / "results", name), name, docs)
    return seen_from_results("\n".join(lines))


def make_first_page(page, folder):
    lines = [f"# {page['title']}", "", MADE, ""]
    for paragraph in page["beginning"]:
        lines += [paragraph, ""]
    lines += first_numbers(page, folder) + chapter_list(page, folder)
    lines += ["## Not measured", ""] + [f"* {item}" for item in page["not_measured"]]
    return "\n".join(lines) + "\n"


def make_pages(docs):
    """The text of each page, by its name as seen from docs/."""
    folder = docs / "results"
    page = read(folder, "page.json")
    named = [name for chapter in page["chapters"] for name in chapter["tables"]]
    present = sorted(path.name for path in folder.glob("*.json") if path.name != "page.json")
    require(sorted(named) == present, "page.json",
            f"chapters: name {sorted(named)}, but there are {present}")
    pages = {"results.md": make_first_page(page, folder)}
    for chapter in page["chapters"]:
        pages[f"results/{chapter['file']}"] = make_chapter(chapter, docs)
    return pages


def first_difference(page, made):
    """Line number, what is there and what should be; None where they are the same."""
    there, wanted = page.split("\n"), made.split("\n")
    for index in range(max(len(there), len(wanted))):
        pair = [texts[index] if index < len(texts) else "(nothing)" for texts in (there, wanted)]
        if pair[0] != pair[1]:
            return index + 1, pair[0], pair[1]
    return None


def check_pages(docs, pages):
    """Fails where a page is not what is made, or nobody makes it."""
    for path in (docs / "results").glob("*.md"):
        if f"results/{path.name}" not in pages:
            raise Invalid(f"docs/results/{path.name}: is no chapter of page.json")
    for name, made in pages.items():
        path = docs / name
        there = path.read_text(encoding="utf-8") if path.is_file() else ""
        difference = first_difference(there, made)
        if difference is not None:
            raise Invalid("docs/{}:{}: is\n  {}\nwhere docs/results makes\n  {}\n"
                          "Run docs/results.py.".format(name, *difference))


def main(arguments):
    if arguments not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        pages = make_pages(DOCS)
        if arguments:
            check_pages(DOCS, pages)
    except Invalid as error:
        print(error, file=sys.stderr)
        return 1
    if not arguments:
        for name, made in pages.items():
            (DOCS / name).write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
