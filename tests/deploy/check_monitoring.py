#!/usr/bin/env python3
"""check_monitoring.py ROOT: checks a checkout's deploy/monitoring without Prometheus or Grafana.

Every metric and label that the alerts, the dashboard and the adapter name is one of docs/metrics.md,
which a test keeps in step with what programs say. Alerts have their section in docs/alerts.md, and
what Prometheus is told to ask is in compose.yaml. Prints "FILE: PLACE: what is wrong" for each finding,
and ends with 1 if there was any.
"""

import json
import pathlib
import re
import sys

import yaml

import metric_table

SEVERITIES = ("info", "warning", "critical")
# Labels that Prometheus puts on every series, by its configuration.
OF_TARGETS = {"instance", "job", "program", "namespace", "le"}


class Monitoring:
    """The files, and what was found wrong with them."""

    def __init__(self, root):
        self.root = pathlib.Path(root)
        self.metrics = metric_table.read(self.root / "docs" / "metrics.md")
        self.problems = []

    def problem(self, file, place, what):
        self.problems.append(f"{file}: {place}: {what}")

    def text(self, name):
        return (self.root / name).read_text(encoding="utf-8")

    def yaml(self, name):
        return yaml.safe_load(self.text(name))

    def check_expression(self, file, place, expression):
        names = metric_table.named_in(expression)
        if not names and not re.search(r"\bup\b", expression):
            self.problem(file, place, f"names no metric: {expression}")
        for name in sorted(names - metric_table.series(self.metrics)):
            self.problem(file, place, f"docs/metrics.md has no {name}")
        for name, selector in re.findall(r"\b((?:corbslam|process)_\w+)\{([^}]*)\}", expression):
            metric = self.metrics.get(re.sub("_(bucket|count|sum)$", "", name), self.metrics.get(name))
            for label in re.findall(r"(\w+)\s*(?:=~|!~|!=|=)", selector):
                if metric and label not in metric.labels | OF_TARGETS:
                    self.problem(file, place, f"{name} has no label {label}")


def sections_of(text):
    return re.findall(r"^## (\w+)$", text, re.MULTILINE)


def check_alerts(monitoring):
    file = "deploy/monitoring/alerts.yaml"
    sections = sections_of(monitoring.text("docs/alerts.md"))
    alerts = [rule for group in monitoring.yaml(file)["groups"] for rule in group["rules"]]
    for rule in alerts:
        name = rule["alert"]
        monitoring.check_expression(file, name, rule["expr"])
        if rule.get("labels", {}).get("severity") not in SEVERITIES:
            monitoring.problem(file, name, f"labels.severity: is none of {SEVERITIES}")
        notes = rule.get("annotations", {})
        if not notes.get("summary"):
            monitoring.problem(file, name, "annotations.summary: is missing")
        if name not in sections or notes.get("runbook") != f"docs/alerts.md#{name.lower()}":
            monitoring.problem(file, name, "annotations.runbook: is no section of docs/alerts.md")
    names = [rule["alert"] for rule in alerts]
    for name in sections:
        if names.count(name) != 1:
            monitoring.problem("docs/alerts.md", name, f"there are {names.count(name)} such alerts")


# What people look for who keep missions for long.
ON_DASHBOARD = (
    "corbslam_mission_memory_bytes", "corbslam_mission_disk_bytes", "corbslam_missions_asleep",
    "corbslam_missions_damaged", "corbslam_backups_safe_time_seconds",
    "corbslam_mission_joined_local_maps", "corbslam_mission_forgotten_local_maps",
    "corbslam_robot_uplink_held_bytes",
)


def check_dashboard(monitoring):
    file = "deploy/monitoring/grafana/dashboards/corbslam.json"
    dashboard = json.loads(monitoring.text(file))
    seen = set()
    shown = set()
    for panel in dashboard["panels"]:
        if panel["id"] in seen:
            monitoring.problem(file, panel["title"], "id: is another panel's")
        seen.add(panel["id"])
        if panel["type"] != "row" and not panel.get("targets"):
            monitoring.problem(file, panel["title"], "targets: has none")
        for target in panel.get("targets", []):
            monitoring.check_expression(file, panel["title"], target["expr"])
            shown |= metric_table.named_in(target["expr"])
    for name in ON_DASHBOARD:
        if name not in shown:
            monitoring.problem(file, name, "no panel shows it")
    for variable in dashboard["templating"]["list"]:
        if variable["type"] == "query":
            monitoring.check_expression(file, variable["name"], variable["definition"])


def check_adapter(monitoring):
    file = "deploy/monitoring/adapter_rules.yaml"
    given = set()
    for rule in monitoring.yaml(file)["externalRules"]:
        name = rule["name"]["as"]
        given.add(name)
        for field in ("seriesQuery", "metricsQuery"):
            monitoring.check_expression(file, name, rule[field])
    scaling = "deploy/kubernetes/fusion_worker_scaling.yaml"
    for item in yaml.safe_load_all(monitoring.text(scaling)):
        for metric in item["spec"].get("metrics", []):
            name = metric["external"]["metric"]["name"]
            if name not in given:
                monitoring.problem(scaling, name, f"{file} does not give it")


def metrics_port(service):
    ports = [argument.rpartition(":")[2] for argument in service.get("command", [])
             if argument.startswith("--metrics-listen=")]
    return ports[0] if ports else None


def check_targets(monitoring):
    file = "deploy/monitoring/prometheus.yaml"
    prometheus = monitoring.yaml(file)
    services = monitoring.yaml("deploy/compose.yaml")["services"]
    for name in prometheus["rule_files"]:
        if not (monitoring.root / "deploy" / "monitoring" / name).exists():
            monitoring.problem(file, "rule_files", f"there is no {name}")
    asked = set()
    for job in prometheus["scrape_configs"]:
        for group in job.get("static_configs", []):
            for target in group["targets"]:
                host, _, port = target.partition(":")
                asked.add(host)
                service = services.get(host, {})
                if metrics_port(service) != port:
                    monitoring.problem(file, target, "no service of compose.yaml listens there")
                if f"/{group['labels']['program']}:" not in service.get("image", ""):
                    monitoring.problem(file, target, f"is no {group['labels']['program']}")
    for host in sorted(set(services) - asked):
        monitoring.problem("deploy/compose.yaml", host, "Prometheus does not ask it")


def check(root):
    monitoring = Monitoring(root)
    for step in (check_alerts, check_dashboard, check_adapter, check_targets):
        step(monitoring)
    return monitoring.problems


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    problems = check(sys.argv[1])
    for problem in problems:
        print(problem, file=sys.stderr)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
