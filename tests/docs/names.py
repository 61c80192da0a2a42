"""Files and functions that pages name in backticks, and that are not there.

`folder/file.cc` and `folder/` must be there; of `folder/file.cc:Function` the file must also have
the function's name before a parenthesis. A page may shorten folders: "`tool/` is `services/x/`".
"""

import pathlib
import re

FENCE = re.compile(r"^```.*?^```[ \t]*$", re.MULTILINE | re.DOTALL)
SHORT = re.compile(r"`([\w.]+/)` is `([\w./]+/)`")
NAME = re.compile(r"`([\w.-]+(?:/[\w.-]+)*/(?:[\w.-]+\.(?:h|cc|md|py|sh|proto|txt)(?::(\w+))?)?)`")


def find_missing(root, page):
    """Lines "page:number: ..." for each name of the page that is not in the sources."""
    text = page.read_text(encoding="utf-8")
    text = FENCE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    shortened = dict(SHORT.findall(text))
    missing = []
    for match in NAME.finditer(text):
        name = match[1].partition(":")[0]
        for short, folder in shortened.items():
            if name.startswith(short):
                name = folder + name[len(short):]
        where = f"{page.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}"
        path = root / name
        if not path.exists():
            missing.append(f"{where}: there is no {name}")
        elif match[2] and not re.search(rf"\b{match[2]}\(", path.read_text(encoding="utf-8")):
            missing.append(f"{where}: {name} has no {match[2]}()")
    return missing


def count_names(page):
    return len(NAME.findall(page.read_text(encoding="utf-8")))


def find_absent_words(root, page):
    """Lines "page:number: ..." for each row | word | meaning | files | whose files lack the word.

    Of "a / b" and "a, b" each is looked for, as one word or several, in any of the row's files.
    """
    absent = []
    for number, line in enumerate(page.read_text(encoding="utf-8").split("\n"), 1):
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("| ") or len(cells) != 3 or cells[0] in ("word", "---"):
            continue
        files = [match[1] for match in NAME.finditer(cells[2])]
        if not files:
            absent.append(f"{page.relative_to(root)}:{number}: {cells[0]} names no file")
            continue
        text = " ".join((root / file).read_text(encoding="utf-8")
                        for file in files if (root / file).is_file())
        text = re.sub(r"[\W_]", "", text).lower()
        for word in re.split(r" / |, ", re.sub(r" \(.*\)", "", cells[0])):
            if re.sub(r"[\W_]", "", word).lower() not in text:
                absent.append(f"{page.relative_to(root)}:{number}: {cells[2]} has no {word}")
    return absent
