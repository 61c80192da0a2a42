#!/usr/bin/env python3
"""What deploy/monitoring holds is good, and each fault that is put in is found by its name."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import check_monitoring
except ImportError as error:
    print(f"skipped: {error} (deploy/packages.txt)", file=sys.stderr)
    sys.exit(1 if os.environ.get("CI") else 77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
DASHBOARD = "deploy/monitoring/grafana/dashboards/corbslam.json"

# File, what is replaced (once), by what, and what has to be said about it.
FAULTS = [
    ("deploy/monitoring/alerts.yaml", "corbslam_journal_writable == 0", "corbslam_journal_writeable == 0",
     "JournalNotWritable: docs/metrics.md has no corbslam_journal_writeable"),
    ("deploy/monitoring/alerts.yaml", "corbslam_acknowledgement_duration_seconds_bucket",
     "corbslam_acknowledgement_duration_seconds",
     "AcknowledgementsSlow: docs/metrics.md has no corbslam_acknowledgement_duration_seconds"),
    ("deploy/monitoring/alerts.yaml", "corbslam_robot_tracking_state{state=",
     "corbslam_robot_tracking_state{status=", "corbslam_robot_tracking_state has no label status"),
    ("deploy/monitoring/alerts.yaml", "severity: critical", "severity: bad", "labels.severity"),
    ("deploy/monitoring/alerts.yaml", "#robotlost", "#robot", "RobotLost: annotations.runbook"),
    ("deploy/monitoring/alerts.yaml", "alert: OutboxFull", "alert: OutboxEmpty",
     "OutboxFull: there are 0 such alerts"),
    ("docs/alerts.md", "## FusionBehind", "## Behind", "FusionBehind: annotations.runbook"),
    ("docs/metrics.md", "`corbslam_batches_waiting`", "`corbslam_batches_queued`",
     "Waiting: docs/metrics.md has no corbslam_batches_waiting"),
    (DASHBOARD, "corbslam_streams_open", "corbslam_streams", "docs/metrics.md has no corbslam_streams"),
    (DASHBOARD, "{mission=~", "{missions=~", "has no label missions"),
    (DASHBOARD, "sum(corbslam_missions_damaged)", "sum(corbslam_missions)",
     "corbslam_missions_damaged: no panel shows it"),
    (DASHBOARD, "\"id\": 3,", "\"id\": 2,", "id: is another panel's"),
    ("deploy/monitoring/adapter_rules.yaml", "as: corbslam_fusion_requests_waiting", "as: waiting",
     "corbslam_fusion_requests_waiting: deploy/monitoring/adapter_rules.yaml does not give it"),
    ("deploy/monitoring/adapter_rules.yaml", "sum(corbslam_fusion_requests_waiting", "sum(waiting",
     "names no metric"),
    ("deploy/monitoring/prometheus.yaml", "store:9464", "store:9465",
     "store:9465: no service of compose.yaml listens there"),
    ("deploy/monitoring/prometheus.yaml", "\"worker_one:9464\", ", "",
     "worker_one: Prometheus does not ask it"),
    ("deploy/monitoring/prometheus.yaml", "[alerts.yaml]", "[alarms.yaml]", "there is no alarms.yaml"),
    ("deploy/monitoring/prometheus.yaml", "program: map_store", "program: map_stores",
     "is no map_stores"),
]


class CheckMonitoringTest(unittest.TestCase):
    def test_ours_is_good(self):
        self.assertEqual(check_monitoring.check(ROOT), [])

    def test_faults_are_found(self):
        for file, good, bad, complaint in FAULTS:
            with self.subTest(file=file, bad=bad), tempfile.TemporaryDirectory() as folder:
                copy = pathlib.Path(folder)
                for name in ("deploy", "docs"):
                    shutil.copytree(ROOT / name, copy / name)
                text = (copy / file).read_text(encoding="utf-8")
                self.assertIn(good, text)
                (copy / file).write_text(text.replace(good, bad, 1), encoding="utf-8")
                problems = check_monitoring.check(copy)
                self.assertTrue(any(complaint in problem for problem in problems), problems)

    @unittest.skipUnless(shutil.which("promtool") or os.environ.get("CI"),
                         "there is no promtool (deploy/packages_checks.txt)")
    def test_prometheus_takes_it_and_the_alerts_fire(self):
        folder = ROOT / "deploy" / "monitoring"
        for command in (["promtool", "check", "config", folder / "prometheus.yaml"],
                        ["promtool", "test", "rules", ROOT / "tests" / "deploy" / "alerts_test.yaml"]):
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
