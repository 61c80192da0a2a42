#!/usr/bin/env python3
"""play_manifests.py [--tag TAG]: runs the pods of deploy/kubernetes without a cluster.

Each workload's pod, as its template has it, is played by `podman kube play`, with the images
localhost/corbslam/*:TAG (deploy/containers/build.sh) and certificates made for the occasion. Two
robots then map a recorded desk through them, and the two maps have to become one. Ends with 77,
"skipped", where containers can't be run.

What is not as in a cluster: one worker, which the store finds by the pod's name; no services, no
network policy, no scaling; ports are not published. podman 4.3 takes secrets whose values are not
encoded, and has to be told of an image for pods' own container.
"""

import argparse
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
MANIFESTS = ROOT / "deploy" / "kubernetes"
# Of a secret, which file of the certificates is which value.
SECRETS = {
    "fusion-worker-tls": {"ca.crt": "ca.pem", "tls.crt": "worker.pem", "tls.key": "worker.key"},
    "map-store-tls": {"ca.crt": "ca.pem", "tls.crt": "store.pem", "tls.key": "store.key",
                      "token.pub": "token.pub"},
}
NETWORK = "corbslam-pods"
PAUSE = "localhost/corbslam/pause"
USER = 10001
RECORDING = ROOT / "tests" / "data" / "tum_fr1_xyz"
ENGINE = """
[containers]
default_ulimits = ["nofile=1024:1024", "nproc=1024:1024"]
[engine]
runtime = "runc"
infra_image = "{pause}"
"""


def skip(why):
    print(f"skipped: {why}", file=sys.stderr)
    sys.exit(77)


def run(*command, check=True, **options):
    """What the command says; ends the program when it fails."""
    done = subprocess.run([str(part) for part in command], check=False, text=True,
                          capture_output=True, **options)
    if check and done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))} ended with {done.returncode}:\n"
                         f"{done.stdout}{done.stderr}")
    return done


def pods_of(path, tag, yaml):
    """The pods of the file's workloads, and the volumes that these claim."""
    made = []
    for workload in yaml.safe_load_all(path.read_text(encoding="utf-8")):
        if workload["kind"] not in ("Deployment", "StatefulSet"):
            continue
        lists = yaml.safe_load((MANIFESTS / "revoked_tokens.yaml").read_text(encoding="utf-8"))
        if any("configMap" in volume for volume in workload["spec"]["template"]["spec"]["volumes"]):
            made.append(lists)
        name, template = workload["metadata"]["name"], workload["spec"]["template"]
        spec = template["spec"]
        for claim in workload["spec"].get("volumeClaimTemplates", []):
            volume = claim["metadata"]["name"]
            made.append({"apiVersion": "v1", "kind": "PersistentVolumeClaim", **claim})
            spec["volumes"].append({"name": volume, "persistentVolumeClaim": {"claimName": volume}})
        for container in spec["containers"]:
            container["image"] = f"localhost/{container['image']}:{tag}"
            container["imagePullPolicy"] = "Never"
            del container["ports"]
        made.append({"apiVersion": "v1", "kind": "Pod",
                     "metadata": {**template["metadata"], "name": name}, "spec": spec})
    return made


def make_pause_image(work):
    """Of the program that does nothing, in which podman puts a pod's containers together."""
    program = next(filter(None, map(shutil.which, ("catatonit", "/usr/libexec/podman/catatonit"))),
                   None)
    if program is None:
        skip("catatonit is not installed (deploy/packages_containers.txt)")
    shutil.copy(program, work / "catatonit")
    container = run("buildah", "from", "scratch").stdout.strip()
    run("buildah", "copy", container, work / "catatonit", "/catatonit")
    run("buildah", "config", "--entrypoint", '["/catatonit", "-P"]', container)
    run("buildah", "commit", "--rm", container, PAUSE)


def make_secrets(work, yaml):
    certificates = work / "certificates"
    run(ROOT / "deploy" / "make_test_certificates.sh", certificates,
        env={**os.environ, "HOSTS": "map-store fusion-worker"})
    for path in (certificates, *certificates.iterdir()):
        os.chown(path, USER, USER)
    for name, files in SECRETS.items():
        values = {key: (certificates / file).read_text() for key, file in files.items()}
        run("podman", "secret", "create", name, "-",
            input=yaml.safe_dump({"apiVersion": "v1", "kind": "Secret", "metadata": {"name": name},
                                  "data": values}))


def wait_until_ready(container):
    """By the command of the readiness probe."""
    for _ in range(60):
        if run("podman", "exec", container, "/usr/bin/health", "readiness", check=False).returncode == 0:
            return
        time.sleep(1)
    raise SystemExit(f"{container} is not ready after a minute:\n"
                     + run("podman", "logs", "--tail", "20", container).stderr)


def drive(work, tag, robot, frames):
    run("podman", "run", "--rm", "--network", NETWORK, "-v", f"{work}/certificates:/certificates:ro",
        "-v", f"{RECORDING}:/recording:ro",
        f"localhost/corbslam/client_agent:{tag}", "--source", f"tum:/recording?frames={frames}",
        "--server", "map-store:50051", "--mission", "lab", "--agent", robot,
        "--tls-ca", "/certificates/ca.pem", "--tls-cert", f"/certificates/{robot}.pem",
        "--tls-key", f"/certificates/{robot}.key", timeout=300)


def count_maps():
    """(local maps, islands), by the store's metrics."""
    infra = run("podman", "pod", "inspect", "map-store", "--format", "{{.InfraContainerID}}").stdout
    address = run("podman", "inspect", infra.strip(), "--format",
                  f'{{{{(index .NetworkSettings.Networks "{NETWORK}").IPAddress}}}}').stdout.strip()
    scraped = run("curl", "-fsS", f"http://{address}:9464/metrics").stdout
    values = {line.split("{")[0]: float(line.split()[-1]) for line in scraped.splitlines()
              if not line.startswith("#")}
    return (values.get("corbslam_mission_local_maps"), values.get("corbslam_mission_islands"))


def refuse_what_is_there():
    """Names are the manifests': nothing that somebody else made is touched."""
    for kind, names in (("pod", ("map-store", "fusion-worker")), ("volume", ("missions", *SECRETS)),
                        ("secret", SECRETS), ("network", (NETWORK,))):
        for name in names:
            if run("podman", kind, "inspect", name, check=False).returncode == 0:
                raise SystemExit(f"there is a {kind} {name} already")


def clean_up():
    run("podman", "pod", "rm", "-f", "map-store", "fusion-worker", check=False)
    run("podman", "volume", "rm", "-f", "missions", *SECRETS, check=False)
    run("podman", "secret", "rm", *SECRETS, check=False)
    run("podman", "network", "rm", "-f", NETWORK, check=False)
    run("podman", "rmi", PAUSE, check=False)


def play(work, tag, yaml):
    make_pause_image(work)
    make_secrets(work, yaml)
    run("podman", "network", "create", NETWORK)
    objects = [made for name in ("fusion_worker.yaml", "map_store.yaml")
               for made in pods_of(MANIFESTS / name, tag, yaml)]
    played = work / "pods.yaml"
    played.write_text(yaml.safe_dump_all(objects), encoding="utf-8")
    run("podman", "kube", "play", "--network", NETWORK, played)
    wait_until_ready("fusion-worker-fusion-worker")
    wait_until_ready("map-store-map-store")
    drive(work, tag, "alpha", "0:85")
    drive(work, tag, "bravo", "46:131")
    for _ in range(60):
        counts = count_maps()
        if counts == (2, 1):
            print("2 local maps, 1 island")
            return
        time.sleep(1)
    raise SystemExit(f"the robots' local maps and their islands are {counts}, not (2, 1)")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tag", default="latest", help="of the images")
    tag = parser.parse_args().tag
    try:
        import yaml
    except ImportError as error:
        skip(error)
    for tool in ("podman", "buildah", "openssl", "curl"):
        if shutil.which(tool) is None:
            skip(f"{tool} is not installed (deploy/packages_containers.txt)")
    if os.geteuid() != 0:
        skip("a network of containers needs root")
    # Stopped from outside it cleans up too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        work.chmod(0o755)
        (work / "containers.conf").write_text(ENGINE.format(pause=PAUSE), encoding="utf-8")
        os.environ["CONTAINERS_CONF"] = str(work / "containers.conf")
        refuse_what_is_there()
        try:
            play(work, tag, yaml)
        finally:
            clean_up()


if __name__ == "__main__":
    main()
