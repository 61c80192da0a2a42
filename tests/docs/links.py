"""Links between Markdown pages that lead nowhere."""

import pathlib
import re

FENCE = re.compile(r"^(```|~~~).*?^\1[ \t]*$", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]*`")
LINK = re.compile(r"\]\(([^()\s]+)\)")
HEADING = re.compile(r"^#{1,6} +(.+?) *$", re.MULTILINE)


def blank(text, pattern):
    """What matches becomes spaces, so that lines keep their numbers."""
    return pattern.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)


def anchors(text):
    """As GitHub makes them of headings."""
    found = set()
    for heading in HEADING.findall(blank(text, FENCE)):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
        number = 0
        while (f"{name}-{number}" if number else name) in found:
            number += 1
        found.add(f"{name}-{number}" if number else name)
    return found


def find_dead_links(root, pages):
    """Lines "page:number: ..." for each link of the pages to what is not below the root."""
    dead = []
    for page in pages:
        text = blank(blank(page.read_text(encoding="utf-8"), FENCE), CODE)
        for match in LINK.finditer(text):
            if re.match(r"[a-z]+:", match[1]):
                continue
            path, _, anchor = match[1].partition("#")
            target = (page.parent / path).resolve() if path else page
            where = f"{page.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}"
            if not target.exists() or root not in (target, *target.parents):
                dead.append(f"{where}: there is no {match[1]}")
            elif anchor and anchor not in anchors(target.read_text(encoding="utf-8")):
                dead.append(f"{where}: {path or page.name} has no heading for #{anchor}")
    return dead


def pages_of(root):
    folders = [path for path in root.iterdir() if path.is_dir()
               and path.name not in ("build", "out", "third_party") and path.name[0] != "."]
    found = [p for f in folders for p in f.rglob("*.md") if "node_modules" not in p.parts]
    return sorted([*root.glob("*.md"), *found])


ROOT = pathlib.Path(__file__).resolve().parents[2]
