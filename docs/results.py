#!/usr/bin/env python3
"""Makes docs/results.md of the tables in docs/results, or checks that it is what they make.

  docs/results.py           writes docs/results.md
  docs/results.py --check   fails, with the first line that differs, where the page is another one

page.json holds the page's beginning, the numbers that stand first (a sentence with {} for each of its
cells of a table: [row, title of the column]), the sections and what was not measured. Every other
file is a table: title, what it means, command, commit, date, machine, columns, rows, and, where there
is one, the lab page with the way there. A column is a title, with rows of cells in the same order; or
{"title", "key", "digits", "scale"}, with rows as a program writes them as JSON, of which the key is
taken ("quiet.p99_ms": p99_ms inside quiet), times the scale. README's `tests/run.sh` runs the check
(docs.results).
"""

import datetime
import json
import pathlib
import re
import sys

DOCS = pathlib.Path(__file__).resolve().parent
# The command of a table whose rows each name one.
IN_ROWS = "as in the rows"
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
    lines = [f"### {table['title']}", "", table["meaning"], "", line(titles),
             line(["---"] * len(titles))]
    lines += [line(row) for row in cells(table, name)]
    command = table["command"]
    source = "Commands" if command == IN_ROWS else f"`{command}`"
    source += f" at {table['commit']}; {table['date']}, {table['machine']}"
    if "lab" in table:
        require((docs / table["lab"]).is_file(), name, f"lab: there is no docs/{table['lab']}")
        source += f"; [more]({table['lab']})"
    return lines + ["", source + f" ([{name}](results/{name})).", ""]


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
        anchor = re.sub(r"[^\w\- ]", "", table["title"].lower()).replace(" ", "-")
        lines.append(f"* {said.format(*values)} ([{table['title']}](#{anchor}))")
    return lines + [""]


def make_page(docs):
    """The text of results.md."""
    folder = docs / "results"
    page = read(folder, "page.json")
    named = [name for section in page["sections"] for name in section["tables"]]
    present = sorted(path.name for path in folder.glob("*.json") if path.name != "page.json")
    require(sorted(named) == present, "page.json",
            f"sections: name {sorted(named)}, but there are {present}")
    lines = [f"# {page['title']}", "",
             "<!-- Made by docs/results.py of docs/results; change those, not this. -->", ""]
    for paragraph in page["beginning"]:
        lines += [paragraph, ""]
    lines += first_numbers(page, folder)
    for section in page["sections"]:
        lines += [f"## {section['title']}", ""]
        for name in section["tables"]:
            lines += render(read(folder, name), name, docs)
    lines += ["## Not measured", ""] + [f"* {item}" for item in page["not_measured"]]
    return "\n".join(lines) + "\n"


def first_difference(page, made):
    """Line number, what is there and what should be; None where they are the same."""
    there, wanted = page.split("\n"), made.split("\n")
    for index in range(max(len(there), len(wanted))):
        pair = [texts[index] if index < len(texts) else "(nothing)" for texts in (there, wanted)]
        if pair[0] != pair[1]:
            return index + 1, pair[0], pair[1]
    return None


def main(arguments):
    if arguments not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        made = make_page(DOCS)
    except Invalid as error:
        print(error, file=sys.stderr)
        return 1
    page = DOCS / "results.md"
    if not arguments:
        page.write_text(made, encoding="utf-8")
        return 0
    difference = first_difference(page.read_text(encoding="utf-8"), made)
    if difference is None:
        return 0
    print("docs/results.md:{}: is\n  {}\nwhere docs/results makes\n  {}\nRun docs/results.py."
          .format(*difference), file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
