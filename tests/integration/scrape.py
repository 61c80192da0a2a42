#!/usr/bin/env python3
"""scrape.py HOST:PORT: what a metrics endpoint says, as JSON, once two parsers have taken it.

The text goes through Prometheus' own parser of its text format, and what that understood through the
strict one of OpenMetrics, which also knows what names, units and histograms have to be. Prints
{FAMILY: {"type", "help", "samples": [{"name", "labels", "value"}]}}; ends with 1 for anything else.
"""

import json
import sys
import urllib.request

from prometheus_client import CollectorRegistry
from prometheus_client.openmetrics.exposition import generate_latest
from prometheus_client.openmetrics.parser import text_string_to_metric_families as parse_strictly
from prometheus_client.parser import text_string_to_metric_families as parse


class Parsed:
    """A collector of families that were parsed."""

    def __init__(self, families):
        self.families = families

    def collect(self):
        return self.families


def read(address):
    with urllib.request.urlopen(f"http://{address}/metrics", timeout=30) as answer:
        return answer.read().decode("utf-8")


def key(sample):
    return (sample.name, tuple(sorted(sample.labels.items())))


def check_series(families):
    """Each family once, each series once."""
    names = [family.name for family in families]
    if len(names) != len(set(names)):
        raise ValueError(f"a family is there twice: {sorted(names)}")
    for family in families:
        if not family.documentation:
            raise ValueError(f"{family.name} has no help")
        keys = [key(sample) for sample in family.samples]
        if len(keys) != len(set(keys)):
            raise ValueError(f"a series of {family.name} is there twice")


def check_strictly(families):
    """The same once more, by the stricter standard."""
    registry = CollectorRegistry()
    registry.register(Parsed(families))
    strict = list(parse_strictly(generate_latest(registry).decode("utf-8")))
    before = {key(sample): sample.value for family in families for sample in family.samples}
    after = {key(sample): sample.value for family in strict for sample in family.samples}
    if before != after:
        raise ValueError(f"OpenMetrics understands something else: {before} and {after}")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    families = list(parse(read(sys.argv[1])))
    check_series(families)
    check_strictly(families)
    print(json.dumps({
        # The parser calls a counter by its name without the ending.
        family.name + ("_total" if family.type == "counter" else ""): {
            "type": family.type,
            "help": family.documentation,
            "samples": [{"name": sample.name, "labels": sample.labels, "value": sample.value}
                        for sample in family.samples]}
        for family in families}))


if __name__ == "__main__":
    main()
