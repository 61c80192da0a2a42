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


def check_image(image, program):
    """The kustomization says where it is from, build.sh makes it, and it runs this program."""
    build = (DEPLOY / "containers/build.sh").read_text(encoding="utf-8")
    target = image.rpartition("/")[2]
    prefix = re.search(r"\bprefix=(\S+) ", build)[1]
    release = re.search(r"project\(corbslam VERSION ([0-9.]+)", (DEPLOY.parent / "CMakeLists.txt").read_text())[1]
    with open(DEPLOY / "kubernetes/backup/kustomization.yaml", encoding="utf-8") as file:
        kustomization = yaml.safe_load(file)
    assert kustomization["resources"] == ["cron_job.yaml"], kustomization["resources"]
    assert kustomization["images"] == [{"name": image, "newName": f"{prefix}/{target}", "newTag": release}], (
        kustomization["images"])
    assert re.search(rf"[| ]{target}\) programs=", build), f"build.sh makes no {target}"
    stages = (DEPLOY / "containers/Containerfile").read_text(encoding="utf-8").split("\nFROM ")
    stage = next(text for text in stages if text.startswith(f"scratch AS {target}\n"))
    assert f'ENTRYPOINT ["{program}"]' in stage, f"{target} does not run {program}"
    assert "USER 10001:10001" in stage
    assert re.search(rf"for program in [^;]*\b{target}\b", stages[1]), f"{target} is not collected"


def check_job(known):
    pod, claims = job()
    container = pod["containers"][0]
    check_image(container["image"], container["command"][0])
    assert pod["securityContext"]["runAsUser"] == 10001
    folder = next(argument.partition("=")[2] for argument in container["args"]
                  if argument.startswith("--out-dir="))
    backups = next(mount for mount in container["volumeMounts"] if mount["name"] == "backups")
    assert backups["mountPath"] == folder and not backups.get("readOnly"), backups
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
    with open(DEPLOY / "compose.yaml", encoding="utf-8") as file:
        services = yaml.safe_load(file)["services"]
    store = services["store"]
    for name in store["environment"]:
        if name.startswith("CORBSLAM_MAP_STORE_"):
            flag = "--" + name.removeprefix("CORBSLAM_MAP_STORE_").lower().replace("_", "-")
            assert flag in known, f"compose.yaml: {name}"
    folder = store["environment"]["CORBSLAM_MAP_STORE_BACKUP_DIR"]
    assert any(volume.endswith(":" + folder) for volume in store["volumes"]), store["volumes"]
    for name, service in services.items():
        assert service.get("mem_limit"), f"compose.yaml: {name}: mem_limit"
        if any(argument.startswith("--token-key=") for argument in service["command"]):
            listed = [argument for argument in service["command"] if argument.startswith("--revoked-tokens=")]
            assert len(listed) == 1, f"compose.yaml: {name}: {listed}"


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
