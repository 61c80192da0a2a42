"""The wire's numbers, as lines, and what of an older release's is not there any more.

A line is "Message.Inner NUMBER LABEL TYPE NAME" for a field, "Enum NUMBER NAME" for a value, and
"Service/Call (REQUEST) (RESPONSE)" for a call. `wire.py FOLDER` prints those of the protos there.
"""

import pathlib
import re
import sys

COMMENT = re.compile(r"//[^\n]*")
TOKEN = re.compile(
    r"\s*(?:(?P<open>(?P<kind>message|enum|service|oneof|extend)\s+(?P<name>[\w.]+)\s*\{)"
    r"|rpc\s+(?P<call>\w+)\s*(?P<request>\([^)]*\))\s*returns\s*(?P<response>\([^)]*\))\s*(?:;|\{(?:[^{}]|\{[^{}]*\})*\})"
    r"|(?P<rest>[^;{}]*);"
    r"|(?P<close>\}))")
FIELD = re.compile(r"(?:(repeated|optional)\s+)?(map\s*<[^>]*>|[\w.]+)\s+(\w+)\s*=\s*(\d+)")
VALUE = re.compile(r"(\w+)\s*=\s*(-?\d+)")


def read_proto(text):
    """The lines of one file."""
    scopes = []
    lines = []
    for match in TOKEN.finditer(COMMENT.sub("", text)):
        path = ".".join(name for kind, name in scopes if kind != "oneof")
        if match["open"]:
            scopes.append((match["kind"], match["name"]))
        elif match["close"]:
            scopes.pop()
        elif match["call"]:
            request, response = (re.sub(r"\s+", " ", match[part]) for part in ("request", "response"))
            lines.append(f"{path}/{match['call']} {request} {response}")
        elif scopes and scopes[-1][0] == "enum":
            value = VALUE.match(match["rest"].strip())
            if value:
                lines.append(f"{path} {value[2]} {value[1]}")
        elif scopes and scopes[-1][0] in ("message", "oneof"):
            field = FIELD.match(match["rest"].strip())
            if field:
                kind = re.sub(r"\s+", "", field[2])
                lines.append(f"{path} {field[4]} {field[1] or 'one'} {kind} {field[3]}")
    return lines


def read_folder(folder):
    """The lines of all protos in a folder, sorted."""
    return sorted(line for file in pathlib.Path(folder).glob("*.proto")
                  for line in read_proto(file.read_text(encoding="utf-8")))


def find_gone(before, now, excused=()):
    """Lines of `before` that `now` has not, but for excused ones."""
    return [line for line in before if line not in set(now) and line not in excused]


if __name__ == "__main__":
    print("\n".join(read_folder(sys.argv[1])))
