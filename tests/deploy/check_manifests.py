#!/usr/bin/env python3
"""check_manifests.py FOLDER: checks a kustomization without a cluster.

Each object by manifests_schema.json, then what lies between objects: that files and names that are
pointed to are there, that selectors select, that ports exist, that flags go with the rest. Prints
"FILE: KIND/NAME: FIELD: what is wrong" for each finding, and ends with 1 if there was any.
"""

import json
import pathlib
import re
import sys

import jsonschema
import yaml

import metric_table

SCHEMA = pathlib.Path(__file__).with_name("manifests_schema.json")
METRICS = pathlib.Path(__file__).resolve().parents[2] / "docs" / "metrics.md"
CMAKE = pathlib.Path(__file__).resolve().parents[2] / "CMakeLists.txt"
RELEASE = re.search(r"project\(corbslam VERSION ([0-9.]+)", CMAKE.read_text(encoding="utf-8"))[1]
WORKLOADS = ("Deployment", "StatefulSet")


class Objects:
    """The objects of a kustomization, and what was found wrong with them."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.problems = []
        self.objects = []
        kustomization = self.read("kustomization.yaml")[0]
        self.images = {image["name"] for image in kustomization.get("images", [])}
        for image in kustomization.get("images", []):
            if image.get("newTag") != RELEASE:
                self.problem("kustomization.yaml", f"images: {image['name']}: newTag is {image.get('newTag')}, the "
                                                   f"release is {RELEASE}")
        resources = kustomization.get("resources", [])
        for name in resources:
            if not (self.folder / name).exists():
                self.problem("kustomization.yaml", f"resources: there is no {name}")
                continue
            self.objects += [(name, document) for document in self.read(name)]
        for path in sorted(self.folder.glob("*.yaml")):
            if path.name not in resources and path.name != "kustomization.yaml":
                self.problem("kustomization.yaml", f"resources: {path.name} is not among them")

    def read(self, name):
        with open(self.folder / name, encoding="utf-8") as file:
            return [document for document in yaml.safe_load_all(file) if document]

    def problem(self, place, what):
        self.problems.append(f"{self.folder / place}: {what}")

    def of_kind(self, *kinds):
        return [(file, item) for file, item in self.objects if item.get("kind") in kinds]

    def find(self, kind, name):
        return next((item for _, item in self.of_kind(kind) if item["metadata"]["name"] == name), None)

    def selected(self, labels):
        """The workloads whose pods have these labels."""
        return [item for _, item in self.of_kind(*WORKLOADS)
                if labels.items() <= item["spec"]["template"]["metadata"]["labels"].items()]


def called(item):
    return f"{item.get('kind')}/{item.get('metadata', {}).get('name')}"


def containers_of(workload):
    return workload["spec"]["template"]["spec"]["containers"]


def ports_of(workload):
    return {port["name"]: port["containerPort"]
            for container in containers_of(workload) for port in container["ports"]}


def check_schema(objects):
    validator = jsonschema.Draft7Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))
    seen = set()
    for file, item in objects.objects:
        for error in validator.iter_errors(item):
            field = ".".join(str(part) for part in error.absolute_path) or "the object"
            objects.problem(file, f"{called(item)}: {field}: {error.message}")
        if called(item) in seen:
            objects.problem(file, f"{called(item)}: is there twice")
        seen.add(called(item))


def check_services(objects):
    for file, service in objects.of_kind("Service"):
        workloads = objects.selected(service["spec"]["selector"])
        # Of the only one there is, what it says while it is not ready still has to reach callers.
        if any(item["kind"] == "StatefulSet" and item["spec"].get("replicas", 1) == 1 for item in workloads) and (
                not service["spec"].get("publishNotReadyAddresses")):
            objects.problem(file, f"{called(service)}: spec.publishNotReadyAddresses: is not true")
        if not workloads:
            objects.problem(file, f"{called(service)}: spec.selector: selects no pods")
        for workload in workloads:
            for port in service["spec"]["ports"]:
                if port["targetPort"] not in ports_of(workload):
                    objects.problem(file, f"{called(service)}: spec.ports: {called(workload)} has no "
                                          f"port named {port['targetPort']}")


def check_workloads(objects):
    for file, workload in objects.of_kind(*WORKLOADS):
        spec, pod = workload["spec"], workload["spec"]["template"]["spec"]

        def problem(what, file=file, workload=workload):
            objects.problem(file, f"{called(workload)}: {what}")

        if not (spec["selector"]["matchLabels"].items()
                <= spec["template"]["metadata"]["labels"].items()):
            problem("spec.selector: does not match spec.template.metadata.labels")
        if "serviceName" in spec and not objects.find("Service", spec["serviceName"]):
            problem(f"spec.serviceName: there is no Service/{spec['serviceName']}")
        if not objects.find("ServiceAccount", pod["serviceAccountName"]):
            problem(f"serviceAccountName: there is no ServiceAccount/{pod['serviceAccountName']}")
        volumes = {volume["name"] for volume in pod.get("volumes", [])}
        volumes |= {claim["metadata"]["name"] for claim in spec.get("volumeClaimTemplates", [])}
        for volume in pod.get("volumes", []):
            name = volume.get("configMap", {}).get("name")
            if name and not objects.find("ConfigMap", name):
                problem(f"volumes: there is no ConfigMap/{name}")
        for container in pod["containers"]:
            check_container(container, volumes, objects, problem)
        check_scraping(workload, problem)
        drain = flag(containers_of(workload)[0], "--drain")
        if drain and float(drain[0]) >= pod["terminationGracePeriodSeconds"]:
            problem(f"--drain: {drain[0]} s are not over within terminationGracePeriodSeconds, "
                    f"{pod['terminationGracePeriodSeconds']}")


def check_scraping(workload, problem):
    """Prometheus finds the metrics by the usual annotations."""
    annotations = workload["spec"]["template"]["metadata"].get("annotations", {})
    wanted = {"prometheus.io/scrape": "true", "prometheus.io/path": "/metrics",
              "prometheus.io/port": str(ports_of(workload).get("metrics"))}
    if not wanted.items() <= annotations.items():
        problem(f"spec.template.metadata.annotations: are not {wanted}")


def flag(container, name):
    return [argument.partition("=")[2] for argument in container["args"]
            if argument.partition("=")[0] == name]


def check_container(container, volumes, objects, problem):
    if container["image"] not in objects.images:
        problem(f"image: kustomization.yaml's images don't say where {container['image']} is from")
    mounts = {mount["mountPath"]: mount["name"] for mount in container["volumeMounts"]}
    for name in mounts.values():
        if name not in volumes:
            problem(f"volumeMounts: there is no volume {name}")
    for name in volumes - set(mounts.values()):
        problem(f"volumes: {name} is mounted nowhere")
    if "--insecure" in container["args"]:
        problem("args: --insecure")
    if flag(container, "--token-key") and not flag(container, "--revoked-tokens"):
        problem("args: --token-key without --revoked-tokens: a token that is lost could not be refused")
    if flag(container, "--data-dir"):
        for name in ("--backup-dir", "--audit-log"):
            if not flag(container, name):
                problem(f"args: need {name}")
    if "memory" not in container["resources"].get("limits", {}):
        problem("resources.limits.memory: is missing")
    paths = [value for name in ("--tls-ca", "--tls-cert", "--tls-key") for value in flag(container, name)]
    if len(paths) != 3:
        problem("args: need --tls-ca, --tls-cert and --tls-key")
    paths += flag(container, "--web-cert") + flag(container, "--web-key")
    paths += flag(container, "--token-key") + flag(container, "--data-dir")
    paths += flag(container, "--revoked-tokens") + flag(container, "--backup-dir")
    paths += [entry["value"] for entry in container.get("env", []) if entry["name"] == "CORBSLAM_HEALTH_CA"]
    for path in paths:
        if not any(path == mount or path.startswith(mount + "/") for mount in mounts):
            problem(f"args: {path} is on no volume")
    own = "https" if flag(container, "--web-cert") else "grpc"
    listen = {name: [int(value.rpartition(":")[2]) for value in flag(container, argument)]
              for name, argument in ((own, "--listen"), ("metrics", "--metrics-listen"))}
    if listen != {port["name"]: [port["containerPort"]] for port in container["ports"]}:
        problem(f"ports: are not what --listen and --metrics-listen say, {listen}")


def check_worker_addresses(objects):
    """A flag --worker is a service and its port, as often as there may be workers."""
    for file, workload in objects.of_kind(*WORKLOADS):
        addresses = [address for container in containers_of(workload)
                     for address in flag(container, "--worker")]
        for address in sorted(set(addresses)):
            host, _, port = address.rpartition(":")
            service = objects.find("Service", host)
            if not service or int(port) not in [p["port"] for p in service["spec"]["ports"]]:
                objects.problem(file, f"{called(workload)}: --worker: no service is at {address}")
                continue
            names = [called(item) for item in objects.selected(service["spec"]["selector"])]
            for _, scaler in objects.of_kind("HorizontalPodAutoscaler"):
                target = scaler["spec"]["scaleTargetRef"]
                most = scaler["spec"]["maxReplicas"]
                if f"{target['kind']}/{target['name']}" in names and addresses.count(address) != most:
                    objects.problem(file, f"{called(workload)}: --worker: {address} is named "
                                          f"{addresses.count(address)} times, maxReplicas is {most}")


def check_scaling(objects):
    for file, scaler in objects.of_kind("HorizontalPodAutoscaler"):
        spec = scaler["spec"]
        target = objects.find(spec["scaleTargetRef"]["kind"], spec["scaleTargetRef"]["name"])
        if not target:
            objects.problem(file, f"{called(scaler)}: spec.scaleTargetRef: is not there")
        elif "replicas" in target["spec"]:
            objects.problem(file, f"{called(target)}: spec.replicas: would undo {called(scaler)}")
        for metric in spec["metrics"]:
            name = metric["external"]["metric"]["name"]
            if name not in metric_table.read(METRICS):
                objects.problem(file, f"{called(scaler)}: spec.metrics: no program has {name}")
        if spec["minReplicas"] > spec["maxReplicas"]:
            objects.problem(file, f"{called(scaler)}: spec.minReplicas: above maxReplicas")
    for file, budget in objects.of_kind("PodDisruptionBudget"):
        if not objects.selected(budget["spec"]["selector"]["matchLabels"]):
            objects.problem(file, f"{called(budget)}: spec.selector: selects no pods")


def check_policies(objects):
    for file, policy in objects.of_kind("NetworkPolicy"):
        spec = policy["spec"]
        own = spec["podSelector"].get("matchLabels")
        if own and not objects.selected(own):
            objects.problem(file, f"{called(policy)}: spec.podSelector: selects no pods")
        for direction, side in (("ingress", "from"), ("egress", "to")):
            for rule in spec.get(direction, []):
                check_rule(objects, file, policy, own, direction, rule, rule.get(side, []))


def check_rule(objects, file, policy, own, direction, rule, peers):
    # The port is the callee's.
    callees = [own] if direction == "ingress" else [
        peer["podSelector"]["matchLabels"] for peer in peers if "podSelector" in peer]
    for peer in peers:
        if "podSelector" in peer and not objects.selected(peer["podSelector"]["matchLabels"]):
            objects.problem(file, f"{called(policy)}: spec.{direction}: podSelector selects no pods")
    for port in rule["ports"]:
        for labels in callees:
            for workload in objects.selected(labels or {}):
                if isinstance(port["port"], str) and port["port"] not in ports_of(workload):
                    objects.problem(file, f"{called(policy)}: spec.{direction}: {called(workload)} has "
                                          f"no port named {port['port']}")


def check(folder):
    objects = Objects(folder)
    check_schema(objects)
    # The rest reads fields that the schema wants.
    if not objects.problems:
        for step in (check_services, check_workloads, check_worker_addresses, check_scaling,
                     check_policies):
            step(objects)
    return objects.problems


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    problems = check(sys.argv[1])
    for problem in problems:
        print(problem, file=sys.stderr)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
