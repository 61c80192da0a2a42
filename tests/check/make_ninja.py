#!/usr/bin/env python3
"""make_ninja.py STEP DATABASE OUT FILES: writes a ninja file that checks every C++ source of FILES
(paths from the root, one a line) that the compile database knows.

STEP is `threads` (clang reads the source without precompiled headers, and analyses its thread safety)
or `tidy`. A file that passed is checked again only when it, a header of it, its flags or the tool's
settings changed: ninja keeps that, as for a build. Prints how many sources there are.
"""

import json
import os
import re
import shlex
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# The database may be gcc's, with precompiled headers: `-include .../cmake_pch.hxx`, -Winvalid-pch and
# -fpch-preprocess must not come along. A source that lacks an include is to fail here, as nothing of the
# build says so any more. What else there is does not change what clang reads.
WANTED = ("-I", "-D", "-U", "-std=", "-march=")

RULES = {
    # No warnings but those that are asked for: the build has its own.
    "threads": "clang++-14 $flags -Wno-everything -Wthread-safety -Werror=thread-safety"
               " -fsyntax-only -MD -MF $out.d -MT $out $in && touch $out",
    # clang-tidy itself does not say what it read.
    "tidy": "clang++-14 $flags -w -M -MF $out.d -MT $out $in &&"
            " clang-tidy-14 --quiet --warnings-as-errors='*' $in -- $flags && touch $out",
}
SETTINGS = {"threads": "", "tidy": " | .clang-tidy"}


def wanted_flags(command):
    words = shlex.split(command)
    flags = []
    for word, following in zip(words, words[1:] + [""]):
        if word == "-isystem":
            flags += [word, following]
        elif word.startswith(WANTED):
            flags.append(word)
    return " ".join(shlex.quote(flag) for flag in flags)


def escape(text):
    return text.replace("$", "$$")


def sources_of(compiled):
    """The sources of what is compiled at once: of a united one those that it includes."""
    if "/Unity/unity_" not in compiled or not os.path.exists(compiled):
        return [compiled]
    with open(compiled, encoding="utf-8") as united:
        return re.findall(r'^#include "(.*)"', united.read(), re.MULTILINE)


def read_database(path):
    """Flags by source, relative to the root; of a source that is in two targets, the first's."""
    with open(path, encoding="utf-8") as database:
        entries = json.load(database)
    flags = {}
    for entry in entries:
        for source in sources_of(os.path.join(entry["directory"], entry["file"])):
            flags.setdefault(os.path.relpath(source, ROOT), wanted_flags(entry["command"]))
    return flags


def main():
    step, database, out, files = sys.argv[1:]
    known = read_database(database)
    with open(files, encoding="utf-8") as listed:
        sources = sorted(set(listed.read().split()) & set(known))
    with open(out, "w", encoding="utf-8") as ninja:
        ninja.write(f"builddir = build/checks/{step}\n")
        ninja.write(f"rule {step}\n  command = {RULES[step]}\n  depfile = $out.d\n  deps = gcc\n")
        ninja.write(f"  description = {step} $in\n")
        for source in sources:
            stamp = f"build/checks/{step}/{source}.passed"
            ninja.write(f"build {stamp}: {step} {source}{SETTINGS[step]}\n")
            ninja.write(f"  flags = {escape(known[source])}\n")
    print(len(sources))


if __name__ == "__main__":
    main()
