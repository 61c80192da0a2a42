"""Folders with sources that docs/architecture.md does not name.

A folder is named as `folder/`; `folder/...` names it with all below it. A folder called testing
belongs to the one that it is in.
"""

import pathlib
import re

SOURCES = {".cc", ".h", ".hpp", ".proto", ".ts"}
NO_ROOMS = {"build", "cmake", "deploy", "docs", "node_modules", "out", "tests", "third_party"}
NAMED = re.compile(r"`([\w./-]+/)(\.\.\.)?`")


def sources_of(root):
    """Sources by their folders, as seen from the root."""
    found = {}
    waiting = [path for path in sorted(root.iterdir()) if path.is_dir()]
    while waiting:
        folder = waiting.pop()
        if folder.name[0] == "." or folder.name in NO_ROOMS:
            continue
        for path in sorted(folder.iterdir()):
            if path.is_dir():
                waiting.append(path)
            elif path.suffix in SOURCES:
                found.setdefault(folder.relative_to(root).as_posix() + "/", []).append(path)
    return {folder: found[folder] for folder in sorted(found) if "/testing/" not in f"/{folder}"}


def find_unnamed_rooms(root, page):
    """Lines of what is to be added to the page."""
    named = NAMED.findall(page.read_text(encoding="utf-8"))
    exact = {folder for folder, _ in named}
    whole = tuple(folder for folder, dots in named if dots)
    return [f"{page.relative_to(root)}: there is no line for {folder} ({len(files)} sources): "
            f"add | `{folder}` | what is in it |"
            for folder, files in sources_of(root).items()
            if folder not in exact and not folder.startswith(whole)]
