#!/usr/bin/env python3
"""The manifests in deploy/kubernetes are good, and each fault that is put in is found by its name."""

import os
import pathlib
import shutil
import sys
import tempfile
import unittest

try:
    import check_manifests
except ImportError as error:
    print(f"skipped: {error} (deploy/packages.txt)", file=sys.stderr)
    sys.exit(1 if os.environ.get("CI") else 77)

MANIFESTS = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "kubernetes"

# File, what is replaced (once), by what, and what has to be said about it.
FAULTS = [
    ("map_store.yaml", "apiVersion: apps/v1", "apiVersion: apps/v1beta1", "apiVersion"),
    ("map_store.yaml", "readOnlyRootFilesystem: true", "readOnlyRootFilesystem: false",
     "containers.0.securityContext"),
    ("map_store.yaml", "runAsNonRoot: true", "runAsNonRoot: false", "securityContext.runAsNonRoot"),
    ("map_store.yaml", "readinessProbe", "readynessProbe", "readynessProbe"),
    ("map_store.yaml", "targetPort: grpc", "targetPort: http", "has no port named http"),
    ("map_store.yaml", "serviceName: map-store", "serviceName: store", "no Service/store"),
    ("map_store.yaml", "            - --worker=fusion-worker:50052\n", "", "7 times, maxReplicas is 8"),
    ("map_store.yaml", "--worker=fusion-worker:50052", "--worker=fusion-worker:50053",
     "no service is at fusion-worker:50053"),
    ("map_store.yaml", "--data-dir=/var/lib/corbslam/", "--data-dir=/data/", "is on no volume"),
    ("map_store.yaml", "--drain=10", "--drain=40", "terminationGracePeriodSeconds"),
    ("map_store.yaml", "defaultMode: 0440", "defaultMode: 0444", "defaultMode"),
    ("map_store.yaml", "- --tls-key=/etc/corbslam/tls/tls.key", "- --insecure", "--insecure"),
    ("map_store.yaml", "--metrics-listen=0.0.0.0:9464", "--metrics-listen=0.0.0.0:9465",
     "--metrics-listen"),
    ("map_store.yaml", "prometheus.io/port: \"9464\"", "prometheus.io/port: \"50051\"",
     "annotations"),
    ("map_store.yaml", "  publishNotReadyAddresses: true\n", "", "publishNotReadyAddresses"),
    ("map_store.yaml", "            - --revoked-tokens=/etc/corbslam/revoked/revoked_tokens\n", "", "--revoked-tokens"),
    ("map_store.yaml", "            - --audit-log=-\n", "", "need --audit-log"),
    ("map_store.yaml", "            - --backup-dir=/var/lib/corbslam-backups\n", "", "need --backup-dir"),
    ("map_viewer.yaml", "            limits: {memory: 2Gi}\n", "", "limits.memory"),
    ("revoked_tokens.yaml", "name: revoked-tokens", "name: revoked", "no ConfigMap/revoked-tokens"),
    ("kustomization.yaml", "newTag: \"", "newTag: \"9", "the release is"),
    ("fusion_worker_scaling.yaml", "name: corbslam_fusion_requests_waiting",
     "name: corbslam_requests_waiting", "no program has corbslam_requests_waiting"),
    ("network_policy.yaml", "port: metrics", "port: metric", "no port named metric"),
    ("fusion_worker.yaml", "selector: {app.kubernetes.io/name: fusion-worker}",
     "selector: {app.kubernetes.io/name: worker}", "Service/fusion-worker: spec.selector"),
    ("fusion_worker.yaml", "image: corbslam/fusion_worker", "image: corbslam/worker",
     "don't say where corbslam/worker is from"),
    ("fusion_worker.yaml", "containerPort: 50052", "containerPort: 50051", "--listen"),
    ("fusion_worker.yaml", "  selector:\n", "  replicas: 3\n  selector:\n", "spec.replicas"),
    ("fusion_worker.yaml", "requests: {cpu: \"1\", memory: 1Gi}", "requests: {cpu: \"1\"}", "memory"),
    ("fusion_worker_scaling.yaml", "kind: Deployment", "kind: StatefulSet", "scaleTargetRef"),
    ("fusion_worker_scaling.yaml", "minAvailable: 1", "minAvailable: 1\n  maxUnavailable: 1", "spec"),
    ("network_policy.yaml", "port: grpc", "port: gprc", "no port named gprc"),
    ("network_policy.yaml", "policyTypes: [Ingress, Egress]", "policyTypes: [Ingress]", "policyTypes"),
    ("map_viewer.yaml", "--web-cert=/etc/corbslam/tls/tls.crt", "--web-cert=/etc/tls.crt", "is on no volume"),
    ("map_viewer.yaml", "path: /healthz", "path: /health", "/healthz"),
    ("service_account.yaml", "name: corbslam", "name: other", "no ServiceAccount/corbslam"),
    ("kustomization.yaml", "  - network_policy.yaml\n", "", "network_policy.yaml is not among them"),
    ("kustomization.yaml", "  - map_store.yaml\n", "  - store.yaml\n", "there is no store.yaml"),
]


class CheckManifestsTest(unittest.TestCase):
    def test_ours_are_good(self):
        self.assertEqual(check_manifests.check(MANIFESTS), [])

    def test_faults_are_found(self):
        for file, good, bad, complaint in FAULTS:
            with self.subTest(file=file, bad=bad), tempfile.TemporaryDirectory() as folder:
                copy = pathlib.Path(folder) / "kubernetes"
                shutil.copytree(MANIFESTS, copy)
                text = (copy / file).read_text(encoding="utf-8")
                self.assertIn(good, text)
                (copy / file).write_text(text.replace(good, bad, 1), encoding="utf-8")
                problems = check_manifests.check(copy)
                self.assertTrue(any(complaint in problem for problem in problems), problems)


if __name__ == "__main__":
    unittest.main()
