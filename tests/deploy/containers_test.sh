#!/bin/sh
# containers_test.sh PROGRAMS: builds the images of the programs in the folder PROGRAMS, lets two
# robots map a simulated street through a store and a worker, each in a container with nothing
# writable but its volume, and asks the store for the fused map, also after its container was
# replaced by another one on the same volume. Ends with 77, "skipped", where containers can't be run.
#
# CORBSLAM_KEEP_IMAGES=1: for another run. CORBSLAM_IMAGE_TAG: uses the images of that tag.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
programs=$(cd "$1" && pwd)
street="sim:city?seed=3&length=100&picture_scale=0.4"
# Of what this run makes.
name=corbslam-test-$$
tag=${CORBSLAM_IMAGE_TAG:-test-$$}
prefix=localhost/corbslam

. "$here/container_tools.sh"
need podman buildah openssl

work=$(mktemp -d)
: > "$work/podman.log"
clean_up() {
  podman rm -f -t 2 "$name-worker" "$name-store" "$name-alpha" "$name-bravo" >/dev/null 2>&1 || true
  podman volume rm -f "$name" >/dev/null 2>&1 || true
  podman network rm -f "$name" >/dev/null 2>&1 || true
  [ -n "${CORBSLAM_KEEP_IMAGES:-}${CORBSLAM_IMAGE_TAG:-}" ] ||
    podman rmi -f "$prefix/map_store:$tag" "$prefix/fusion_worker:$tag" \
      "$prefix/client_agent:$tag" >/dev/null 2>&1 || true
  rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 1' HUP INT TERM

fail() {
  echo "containers_test.sh: $*" >&2
  # Where there is no systemd, podman complains for each container that it can't set timers.
  cat "$work/podman.log" >&2
  for container in worker store alpha bravo; do
    echo "--- $container" >&2
    podman logs --tail 30 "$name-$container" >&2 2>&1 || true
  done
  exit 1
}

[ -n "${CORBSLAM_IMAGE_TAG:-}" ] ||
  "$root/deploy/containers/build.sh" --binaries "$programs" --tag "$tag" > "$work/build.log" 2>&1 ||
  { cat "$work/build.log" >&2; fail "the images can't be built"; }
for program in map_store fusion_worker map_viewer client_agent; do
  podman image inspect --format '{{index .RepoTags 0}} {{.Size}} bytes, user {{.User}}' \
    "$prefix/$program:$tag"
done

HOSTS="$name-store $name-worker" "$root/deploy/make_test_certificates.sh" "$work/certificates"
# A robot's image holds no simulator: the street is drawn before.
"$programs/corbslam" simulate --source "$street" --layout kitti --out "$work/street" \
  > "$work/street.log" || fail "the street can't be drawn"
# Containers run as a user of their own.
chown -R 10001:10001 "$work/certificates" "$work/street"
podman network create "$name" >/dev/null || skip "no network for containers can be made"
podman volume create "$name" >/dev/null

# run NAME PROGRAM IDENTITY [OPTION...] -- ARGUMENT...: starts a container.
run() {
  container=$1 program=$2 identity=$3 options=''
  shift 3
  while [ "$1" != -- ]; do options="$options $1"; shift; done
  shift
  # shellcheck disable=SC2086
  podman run -d --name "$name-$container" --network "$name" \
    --read-only --read-only-tmpfs=false --cap-drop ALL --security-opt no-new-privileges \
    --ulimit nofile=1024:1024 --ulimit nproc=1024:1024 \
    -v "$work/certificates:/certificates:ro" -e CORBSLAM_HEALTH_CA=/certificates/ca.pem \
    $options "$prefix/$program:$tag" "$@" --tls-ca /certificates/ca.pem \
    --tls-cert "/certificates/$identity.pem" --tls-key "/certificates/$identity.key" \
    >/dev/null 2>> "$work/podman.log" || fail "$container can't be started"
}

wait_until_healthy() {
  for _ in $(seq 60); do
    if podman healthcheck run "$name-$1" >/dev/null 2>&1; then return 0; fi
    sleep 1
  done
  fail "$1 is not healthy after a minute"
}

start_store() {
  run store map_store store -v "$name:/var/lib/corbslam" -p 127.0.0.1::50051 -- \
    --listen 0.0.0.0:50051 --data-dir /var/lib/corbslam --worker "$name-worker:50052"
  wait_until_healthy store
  address=$(podman port "$name-store" 50051/tcp)
}

start_robot() {
  run "$1" client_agent "$1" -v "$work/street:/street:ro" -- --source "kitti:/street?frames=$2" \
    --server "$name-store:50051" --mission lab --agent "$1"
}

# Prints "MAPS ISLANDS KEYFRAMES POINTS" of the mission; fails while fusion has something to do.
look() {
  "$programs/corbslam" mission list --server "$address" --tls-ca "$work/certificates/ca.pem" \
    --tls-cert "$work/certificates/operator.pem" --tls-key "$work/certificates/operator.key" \
    > "$work/missions" 2> "$work/problem" || return 1
  awk '$1 == "missions/lab" && ($NF == "idle" || $NF == "asleep") {print $3, $4, $5, $6; found = 1} END {exit !found}' \
    "$work/missions"
}

wait_for_idle() {
  for _ in $(seq 60); do
    if look; then return 0; fi
    sleep 1
  done
  fail "no idle mission after a minute: $(cat "$work/missions" "$work/problem")"
}

run worker fusion_worker worker -- --listen 0.0.0.0:50052
wait_until_healthy worker
start_store
[ "$(podman inspect --format '{{.HostConfig.ReadonlyRootfs}}' "$name-store")" = true ] ||
  fail "the store's file system can be written to"

start_robot alpha 0:70
start_robot bravo 40:110
for robot in alpha bravo; do
  code=$(podman wait "$name-$robot")
  [ "$code" = 0 ] || fail "$robot ended with $code"
done
before=$(wait_for_idle)
echo "local maps, islands, keyframes, map points: $before"
case $before in
  "2 1 "*) ;;
  *) fail "the two robots' maps are not one island" ;;
esac

podman stop -t 20 "$name-store" >/dev/null
code=$(podman inspect --format '{{.State.ExitCode}}' "$name-store")
[ "$code" = 0 ] || fail "the store ended with $code when it was told to stop"
podman rm "$name-store" >/dev/null 2>> "$work/podman.log"
start_store
after=$(wait_for_idle)
echo "after the store's container was replaced: $after"
[ "$after" = "$before" ] || fail "another map after the restart: $after, not $before"
echo "passed"
