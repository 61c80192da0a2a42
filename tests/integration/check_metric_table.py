#!/usr/bin/env python3
"""check_metric_table.py METRICS.md PROGRAM=SCRAPE.json...: the tables are what programs really say.

A SCRAPE is what scrape.py printed of a PROGRAM. Prints what is in one and not in the other, with a
wrong type or other labels, and ends with 1 if there was anything.
"""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "deploy"))
import metric_table  # pylint: disable=wrong-import-position


def labels_of(family):
    """Names of its labels, without the one that a histogram's buckets have."""
    return {label for sample in family["samples"] for label in sample["labels"]} - {"le"}


def differences(documented, program, scrape):
    for name, family in sorted(scrape.items()):
        metric = documented.get(name)
        if metric is None or program not in metric.programs:
            yield f"{program} says {name}, which is in no table for it"
            continue
        if metric.type != family["type"]:
            yield f"{name} is a {family['type']}, the table says {metric.type}"
        if metric.labels != labels_of(family):
            yield f"{name} has the labels {sorted(labels_of(family))}, the table says " \
                  f"{sorted(metric.labels)}"
    for name, metric in sorted(documented.items()):
        if program in metric.programs and name not in scrape:
            yield f"{program} does not say {name}, which a table has"


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    documented = metric_table.read(sys.argv[1])
    problems = []
    for argument in sys.argv[2:]:
        program, _, path = argument.partition("=")
        scrape = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
        problems += differences(documented, program, scrape)
    for problem in problems:
        print(problem, file=sys.stderr)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
