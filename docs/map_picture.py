#!/usr/bin/env python3
"""Draws docs/images/map.svg: processes, the streams between them, and the rooms of the sources.

  docs/map_picture.py           writes the picture
  docs/map_picture.py --check   fails where the picture is another one

Rooms are those of the ladders in tests/integration/include_rules.cc, higher ones above lower ones.
"""

import pathlib
import re
import sys

DOCS = pathlib.Path(__file__).resolve().parent
RULES = DOCS.parent / "tests/integration/include_rules.cc"
PICTURE = DOCS / "images/map.svg"

WIDTH, MARGIN, GAP = 1080, 20, 12
ROW, ROOM = 26, 21
CHAR = 6.7  # Of a letter of the rooms' names.
COLOURS = {"services": "#e8e3f2", "client_agent": "#dcebd8", "map_store": "#d8e6f3",
           "fusion_worker": "#f6e7d2", "slam": "#ececec"}
# Programs, and the streams between neighbours: what goes which way.
PROCESSES = [("client_agent", "a robot"), ("map_store", "a server"), ("fusion_worker", "servers")]
STREAMS = [[("right", "Sync: batches"), ("left", "Sync: shared updates")],
           [("right", "FusionWorker: views"), ("left", "verdicts, poses")]]


def read_ladders(text):
    """Rooms of each top folder by their heights: {"slam": {"util": 0, ...}, ...}."""
    body = text[text.index("Ladders() {"):]
    body = body[:body.index("return ladders;")]
    ladders, top = {}, None
    for name, height in re.findall(r'\{\s*"([\w/]+)",\s*(\d+|\{)', body):
        if height == "{":
            top = ladders.setdefault(name, {})
        else:
            top[name] = int(height)
    return ladders


class Drawing:
    def __init__(self):
        self.parts = []

    def box(self, x, y, width, height, fill, stroke="#888"):
        self.parts.append(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="4" '
                          f'fill="{fill}" stroke="{stroke}"/>')

    def text(self, x, y, text, size=12, anchor="middle", weight="normal"):
        self.parts.append(f'<text x="{x:g}" y="{y:g}" font-size="{size}" text-anchor="{anchor}" '
                          f'font-weight="{weight}">{text}</text>')

    def arrow(self, x0, x1, y):
        self.parts.append(f'<line x1="{x0:g}" y1="{y:g}" x2="{x1:g}" y2="{y:g}" stroke="#333" '
                          'stroke-width="1.5" marker-end="url(#tip)"/>')

    def svg(self, height):
        return "\n".join([
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height:g}" '
            f'viewBox="0 0 {WIDTH} {height:g}" font-family="DejaVu Sans Mono, monospace">',
            "<!-- Drawn by docs/map_picture.py. -->",
            '<defs><marker id="tip" markerWidth="8" markerHeight="8" refX="7" refY="4" '
            'orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="#333"/></marker></defs>',
            f'<rect width="{WIDTH}" height="{height:g}" fill="white"/>', *self.parts, "</svg>", ""])


def rows_of(rooms, width):
    """Rows of names, the highest first; those of one height may take several."""
    rows = []
    for height in sorted(set(rooms.values()), reverse=True):
        row, used = [], 0.0
        for name in sorted(name for name in rooms if rooms[name] == height):
            needed = len(name) * CHAR + 14 + 6
            if row and used + needed > width - 20:
                rows.append(row)
                row, used = [], 0.0
            row.append(name)
            used += needed
        rows.append(row)
    return rows


def panel_height(rooms, width):
    return 30 + ROW * len(rows_of(rooms, width))


def draw_panel(drawing, name, rooms, x, y, width, height):
    drawing.box(x, y, width, height, COLOURS[name])
    drawing.text(x + 10, y + 18, f"{name}/", 13, "start", "bold")
    if not rooms:
        drawing.text(x + width / 2, y + height / 2, "pure functions", 11)
    # The lowest rooms stand on the floor.
    rows = rows_of(rooms, width)
    top = y + height - ROW * len(rows)
    for number, row in enumerate(rows):
        widths = [len(room) * CHAR + 14 for room in row]
        left = x + (width - sum(widths) - 6 * (len(row) - 1)) / 2
        for room, room_width in zip(row, widths):
            drawing.box(left, top + number * ROW, room_width, ROOM, "white")
            drawing.text(left + room_width / 2, top + number * ROW + 15, room, 11)
            left += room_width + 6


def draw_processes(drawing, y):
    width, height = 200, 88
    step = (WIDTH - 2 * MARGIN - width) / 2
    lefts = [MARGIN + step * i for i in range(3)]
    for left, (name, where) in zip(lefts, PROCESSES):
        drawing.box(left, y, width, height, COLOURS[name], "#333")
        drawing.text(left + width / 2, y + 40, name, 14, weight="bold")
        drawing.text(left + width / 2, y + 60, where)
    for left, streams in zip(lefts, STREAMS):
        ends = (left + width + 4, left + step - 4)
        for number, (way, label) in enumerate(streams):
            at = y + 30 + 36 * number
            drawing.arrow(*(ends if way == "right" else ends[::-1]), at)
            drawing.text(sum(ends) / 2, at - 6, label, 11)
    # People and their tool.
    middle = lefts[1] + width / 2
    drawing.parts.append(f'<line x1="{middle:g}" y1="{y + height + 2:g}" x2="{middle:g}" '
                         f'y2="{y + height + 38:g}" stroke="#333" stroke-width="1.5" '
                         'marker-end="url(#tip)"/>')
    drawing.text(middle + 10, y + height + 22, "WatchMap, look-ups", 11, "start")
    drawing.box(middle - 100, y + height + 40, 200, 30, "white", "#333")
    drawing.text(middle, y + height + 60, "corbslam: people", 12)
    return y + height + 70


def draw(ladders):
    drawing = Drawing()
    y = draw_processes(drawing, MARGIN) + 24
    whole = WIDTH - 2 * MARGIN
    height = panel_height(ladders["services"], whole)
    draw_panel(drawing, "services", ladders["services"], MARGIN, y, whole, height)
    y += height + GAP
    columns = {"client_agent": 400, "map_store": 460,
               "fusion_worker": whole - 860 - 2 * GAP}
    height = max(panel_height(ladders.get(name, {}), width) for name, width in columns.items())
    x = MARGIN
    for name, width in columns.items():
        draw_panel(drawing, name, ladders.get(name, {}), x, y, width, height)
        x += width + GAP
    y += height + GAP
    height = panel_height(ladders["slam"], whole)
    draw_panel(drawing, "slam", ladders["slam"], MARGIN, y, whole, height)
    return drawing.svg(y + height + MARGIN)


def main(arguments):
    if arguments not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    picture = draw(read_ladders(RULES.read_text(encoding="utf-8")))
    if not arguments:
        PICTURE.write_text(picture, encoding="utf-8")
        return 0
    if PICTURE.read_text(encoding="utf-8") == picture:
        return 0
    print("docs/images/map.svg is not what the ladders of tests/integration/include_rules.cc make: "
          "run docs/map_picture.py", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
