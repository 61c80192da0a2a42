#!/usr/bin/env python3
"""check_fleet.py [MAP_STORE]: what a fleet is deployed with fits together.

The patches of deploy/kubernetes_fleet are applied to deploy/kubernetes, as kubectl would, and what
comes of it is checked like that (check_manifests.py), but for objects of the database's operator.
Of deploy/compose.fleet.yaml, secrets, networks, volumes and addresses are there. With MAP_STORE, the
program, it knows all flags. Prints what is wrong, and ends with 1 if anything was.
"""

import copy
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import yaml

import check_manifests

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"
FLEET = DEPLOY / "kubernetes_fleet"
# Of the operator.
FOREIGN = ("Cluster",)


def apply(item, operations):
    """Applies a JSON patch (RFC 6902), as far as we use it."""
    for operation in operations:
        *path, last = operation["path"].strip("/").split("/")
        at = item
        for part in path:
            at = at[int(part) if isinstance(at, list) else part]
        if operation["op"] == "remove":
            del at[last]
        elif isinstance(at, list) and last == "-":
            at.append(copy.deepcopy(operation["value"]))
        elif operation["op"] == "replace" and last not in at and last != "publishNotReadyAddresses":
            raise KeyError(f"{operation['path']} is not there")
        else:
            at[last] = copy.deepcopy(operation["value"])


def build():
    """{file: objects} of the fleet's kustomization."""
    base = yaml.safe_load((DEPLOY / "kubernetes/kustomization.yaml").read_text(encoding="utf-8"))
    fleet = yaml.safe_load((FLEET / "kustomization.yaml").read_text(encoding="utf-8"))
    files = {name: list(yaml.safe_load_all((DEPLOY / "kubernetes" / name).read_text(encoding="utf-8")))
             for name in base["resources"]}
    for name in fleet["resources"]:
        if name != "../kubernetes":
            files[name] = list(yaml.safe_load_all((FLEET / name).read_text(encoding="utf-8")))
    for patch in fleet["patches"]:
        text = patch.get("patch") or (FLEET / patch["path"]).read_text(encoding="utf-8")
        found = [item for items in files.values() for item in items
                 if item["kind"] == patch["target"]["kind"]
                 and item["metadata"]["name"] == patch["target"]["name"]]
        if len(found) != 1:
            raise KeyError(f"{patch['target']}: there are {len(found)}")
        apply(found[0], yaml.safe_load(text))
    return base, files


def check_kubernetes():
    base, files = build()
    # What the schema of one store's deployment does not know.
    store = next(item for item in files["map_store.yaml"] if item["kind"] == "StatefulSet")
    problems = []
    if store["spec"]["replicas"] < 2:
        problems.append("map-store: a fleet has several")
    args = store["spec"]["template"]["spec"]["containers"][0]["args"]
    if not any(argument.startswith("--journal-lease=") for argument in args):
        problems.append("map-store: --journal-lease is missing")
    with tempfile.TemporaryDirectory() as folder:
        kept = {name: [item for item in items if item["kind"] not in FOREIGN
                       and item["metadata"]["name"] != "corbslam-database"]
                for name, items in files.items()}
        for name, items in kept.items():
            (pathlib.Path(folder) / name).write_text(
                yaml.safe_dump_all(json.loads(json.dumps(items))), encoding="utf-8")
        (pathlib.Path(folder) / "kustomization.yaml").write_text(
            yaml.safe_dump({**base, "resources": list(kept)}), encoding="utf-8")
        objects = check_manifests.Objects(folder)
        for step in (check_manifests.check_services, check_manifests.check_worker_addresses,
                     check_manifests.check_scaling):
            step(objects)
        for file, item in objects.of_kind("StatefulSet"):
            pod = item["spec"]["template"]["spec"]
            volumes = {volume["name"] for volume in pod["volumes"]}
            for container in pod["containers"]:
                check_manifests.check_container(
                    container, volumes, objects, lambda what, file=file: objects.problem(file, what))
        # Names of one store each are to be known before it is ready.
        problems += [problem.replace(folder, "deploy/kubernetes_fleet") for problem in objects.problems]
    return problems, [args]


def check_compose():
    compose = yaml.safe_load((DEPLOY / "compose.fleet.yaml").read_text(encoding="utf-8"))
    problems = []
    arguments = []
    for name, service in compose["services"].items():
        def problem(what, name=name):
            problems.append(f"deploy/compose.fleet.yaml: {name}: {what}")
        if "mem_limit" not in service:
            problem("mem_limit is missing")
        for kind in ("secrets", "networks"):
            for used in service.get(kind, []):
                if used not in compose[kind]:
                    problem(f"{kind}: there is no {used}")
        for volume in service.get("volumes", []):
            source = volume.partition(":")[0]
            if source.startswith(".") and not (DEPLOY / source).exists():
                problem(f"volumes: there is no {source}")
            if not source.startswith(".") and source not in compose["volumes"]:
                problem(f"volumes: there is no {source}")
        command = service.get("command", [])
        for host in re.findall(r"--(?:worker|store|advertise)=(\w+):", " ".join(command)):
            if host not in compose["services"]:
                problem(f"there is no service {host}")
        if "map_store:" in service["image"]:
            arguments.append(command)
            for host in re.search(r"corbslam@([\w,]+)/", " ".join(command))[1].split(","):
                if "database" not in compose["services"][host]["networks"]:
                    problem(f"{host} is not in the network database")
    names = compose["services"]["database"]["command"][1]
    standbys = {service["environment"]["STANDBY"] for service in compose["services"].values()
                if "STANDBY" in service.get("environment", {})}
    if not all(standby in names for standby in standbys):
        problems.append(f"deploy/compose.fleet.yaml: database: {names} has not all of {standbys}")
    return problems, arguments


def main():
    problems, arguments = check_kubernetes()
    more, of_compose = check_compose()
    problems += more
    if len(sys.argv) > 1:
        known = subprocess.run([sys.argv[1], "--help-all"], capture_output=True, check=True, text=True).stdout
        for argument in sum(arguments + of_compose, []):
            flag = argument.partition("=")[0]
            if not re.search(rf"{re.escape(flag)}\b", known):
                problems.append(f"map_store knows no {flag}")
    for problem in problems:
        print(problem, file=sys.stderr)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
