"""The tables of docs/metrics.md: which metrics there are.

A table stands under a heading "## of PROGRAM", or "## of all programs", and has the rows
"| `name` | type | labels | what |", labels separated by commas.
"""

import dataclasses
import pathlib
import re

PROGRAMS = ("map_store", "fusion_worker", "client_agent")
# What a histogram's series are called.
ENDINGS = ("_bucket", "_count", "_sum")


@dataclasses.dataclass
class Metric:
    type: str
    labels: set
    programs: set


def read(path):
    """{name: Metric}"""
    metrics = {}
    programs = ()
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        heading = re.match(r"## of (.*)", line)
        if heading:
            programs = PROGRAMS if heading[1] == "all programs" else re.findall(r"\w+_\w+", heading[1])
            continue
        row = re.match(r"\| `(\w+)` \| (\w+) \|([^|]*)\| [^|]+ \|$", line)
        if row:
            labels = {label.strip(" `") for label in row[3].split(",") if label.strip()}
            metric = metrics.setdefault(row[1], Metric(row[2], labels, set()))
            metric.programs.update(programs)
    return metrics


def series(metrics):
    """The names by which these metrics' series can be asked for."""
    names = set()
    for name, metric in metrics.items():
        names.update([name + ending for ending in ENDINGS] if metric.type == "histogram" else [name])
    return names


def named_in(expression):
    """The names of ours in a PromQL expression, and those that every process has."""
    return set(re.findall(r"\b(?:corbslam|process)_\w+", expression))
