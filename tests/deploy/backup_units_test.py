#!/usr/bin/env python3
"""backup_units_test.py CORBSLAM MAP_STORE: what deploy/ runs for backups has flags that there are.

CORBSLAM and MAP_STORE are the programs. It looks at the systemd unit and its flags, at the
Kubernetes job and at the compose file.
"""

import pathlib
import re
import subprocess
import sys

import yaml

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"


def flags_of(*command):
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return set(re.findall(r"--[a-z][a-z-]*", said))


def unit_flags():
    unit = (DEPLOY / "systemd/corbslam_backup.service").read_text(encoding="utf-8")
    environment = (DEPLOY / "systemd/corbslam_backup.env").read_text(encoding="utf-8")
    start = re.search(r"^ExecStart=(.*)$", unit, re.MULTILINE).group(1)
    assert start.startswith("/usr/bin/corbslam mission backup-all "), start
    more = re.search(r"^CORBSLAM_BACKUP_FLAGS=(.*)$", environment, re.MULTILINE).group(1)
    return re.findall(r"--[a-z][a-z-]*", start + " " + more)


def job():
    with open(DEPLOY / "kubernetes/backup/cron_job.yaml", encoding="utf-8") as file:
        objects = list(yaml.safe_load_all(file))
    claims = {item["metadata"]["name"] for item in objects
              if item["kind"] == "PersistentVolumeClaim"}
    pod = next(item for item in objects if item["kind"] == "CronJob")
    pod = pod["spec"]["jobTemplate"]["spec"]["template"]["spec"]
    return pod, claims


def check_job(known):
    pod, claims = job()
    container = pod["containers"][0]
    assert container["command"] == ["/usr/bin/corbslam", "mission", "backup-all"]
    for argument in container["args"]:
        assert argument.partition("=")[0] in known, f"cron_job.yaml: {argument}"
    mounts = {mount["name"] for mount in container["volumeMounts"]}
    assert mounts == {volume["name"] for volume in pod["volumes"]}, mounts
    for volume in pod["volumes"]:
        claim = volume.get("persistentVolumeClaim")
        assert claim is None or claim["claimName"] in claims, claim
    assert container["securityContext"]["readOnlyRootFilesystem"]
    assert pod["securityContext"]["runAsNonRoot"]


def check_compose(known):
    with open(DEPLOY / "compose.backup.yaml", encoding="utf-8") as file:
        store = yaml.safe_load(file)["services"]["store"]
    for name in store["environment"]:
        flag = "--" + name.removeprefix("CORBSLAM_MAP_STORE_").lower().replace("_", "-")
        assert flag in known, f"compose.backup.yaml: {name}"
    folder = store["environment"]["CORBSLAM_MAP_STORE_BACKUP_DIR"]
    assert store["volumes"][0].endswith(":" + folder), store["volumes"]


def main():
    corbslam, map_store = sys.argv[1:3]
    known = flags_of(corbslam, "mission", "backup-all", "--help")
    for flag in unit_flags():
        assert flag in known, f"corbslam_backup.service: {flag}"
    check_job(known)
    check_compose(flags_of(map_store, "--help-all"))
    timer = (DEPLOY / "systemd/corbslam_backup.timer").read_text(encoding="utf-8")
    assert "Persistent=true" in timer


if __name__ == "__main__":
    main()
