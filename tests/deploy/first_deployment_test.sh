#!/bin/bash
# first_deployment_test.sh [--packages DIR]: does what docs/first_deployment.md says, command by command, on
# two fresh Debians with systemd and SSH, each a container of its own, and looks whether the two robots' maps
# became one. Half an hour and more, nearly all of it the build. Ends with 77, "skipped", where there
# are no containers.
#
# --packages DIR   takes the packages in DIR instead of building them there
# CORBSLAM_CCACHE  a folder of ccache's that the build may use
# CORBSLAM_OUT     a folder for the picture of the map
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
page=$root/docs/first_deployment.md
name=corbslam-first-$$
packages=
if [ "${1:-}" = --packages ]; then packages=$(cd "$2" && pwd); fi

# shellcheck source=tests/deploy/container_tools.sh
. "$root/tests/deploy/container_tools.sh"
need podman debootstrap ssh-keygen

work=$(mktemp -d)
clean_up() {
  podman rm -f -t 2 "$name-server" "$name-robots" >/dev/null 2>&1 || true
  podman network rm -f "$name" >/dev/null 2>&1 || true
  podman rmi -f "localhost/$name" >/dev/null 2>&1 || true
  rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 1' HUP INT TERM

fail() {
  echo "first_deployment_test.sh: $*" >&2
  podman exec "$name-server" journalctl --no-pager -n 40 >&2 || true
  exit 1
}

# The commands of the page's block NAME.
block() {
  local commands
  commands=$(awk -v fence='```' -v head="\`\`\`$1" '$0 == head {inside = 1; next}
    $0 == fence {inside = 0} inside' "$page")
  [ -n "$commands" ] || fail "$page has no commands \"$1\""
  printf '%s\n' "$commands"
}

# A machine as Debian's installer leaves it, as far as the page needs it; minbase has no init.
make_machine() {
  debootstrap --variant=minbase --include=systemd,systemd-sysv,dbus,openssh-server,openssh-client \
    bookworm "$work/machine" > "$work/debootstrap.log" 2>&1 ||
    { cat "$work/debootstrap.log" >&2; fail "no Debian can be made"; }
  local sources
  for sources in sources.list sources.list.d/debian.sources; do
    if [ -e "/etc/apt/$sources" ]; then cp "/etc/apt/$sources" "$work/machine/etc/apt/$sources"; fi
  done
  ssh_of_robots "$work/machine"
  tar -C "$work/machine" -c . | podman import -q - "localhost/$name" >/dev/null
  rm -rf "$work/machine"
}

# The robots' machine may log in at the server, whose key it knows. (All of it is gone with the test.)
ssh_of_robots() {
  local folder=$1/root/.ssh
  mkdir -p "$folder"
  chmod 700 "$folder"
  ssh-keygen -q -t ed25519 -N '' -f "$folder/id_ed25519"
  cp "$folder/id_ed25519.pub" "$folder/authorized_keys"
  echo "server.lan $(cut -d' ' -f1,2 "$1/etc/ssh/ssh_host_ed25519_key.pub")" > "$folder/known_hosts"
}

# start NAME [OPTION...]
start() {
  local machine=$1
  shift
  # systemd gives credentials to its services by mounts that containers don't pass on by themselves.
  podman run -d --name "$name-$machine" --hostname "$machine" --network "$name" --privileged \
    --systemd=always --ulimit nofile=1024:1024 --ulimit nproc=1024:1024 "$@" "localhost/$name" \
    sh -c 'mount --make-rshared / && exec /sbin/init' > /dev/null
  local state=
  for _ in $(seq 60); do
    state=$(podman exec "$name-$machine" systemctl is-system-running 2>/dev/null || true)
    if [ "$state" = running ]; then return 0; fi
    sleep 1
  done
  fail "systemd of $machine does not run: $state"
}

# on MACHINE COMMAND: as a person who has logged in.
on() {
  echo "$1# $2"
  podman exec -w /root -e DEBIAN_FRONTEND=noninteractive -e LC_ALL=C.UTF-8 "$name-$1" bash -c "$2" \
    > "$work/said" 2>&1 < /dev/null || { tail -n 40 "$work/said" >&2; fail "$1: $2"; }
}

make_machine
podman network create "$name" >/dev/null || skip "no network for containers can be made"
git clone -q --bare "$root" "$work/repository"
options=(-v "$work/repository:/srv/corbslam.git:ro" --network-alias server.lan)
if [ -n "${CORBSLAM_CCACHE:-}" ]; then
  options+=(-v "$CORBSLAM_CCACHE:/ccache" -e CCACHE_DIR=/ccache -e CCACHE_BASEDIR=/root/corbslam)
fi
start server "${options[@]}"
start robots

count=0
while read -r command; do
  count=$((count + 1))
  if [ -n "$packages" ] && [[ $command == *build_packages* ]]; then
    podman exec "$name-server" mkdir -p /root/corbslam/out
    podman cp "$packages" "$name-server:/root/corbslam/out/packages"
    continue
  fi
  on server "${command/REPOSITORY//srv/corbslam.git}"
done < <(block server)
while read -r command; do
  count=$((count + 1))
  on robots "$command"
done < <(block robots)
[ "$count" -le 10 ] || fail "the page has $count commands"

fused="2 robots, 2 local maps in 1 island"
# The second robot's last keyframes may still be on their way into the map.
for _ in $(seq 60); do
  on robots "$(block look | head -n 1)"
  if grep -q "$fused" "$work/said"; then break; fi
  sleep 1
done
cat "$work/said"
grep -q "$fused" "$work/said" || fail "the robots' maps are not one island"
on robots "$(block look | tail -n 1)"
if [ -n "${CORBSLAM_OUT:-}" ]; then podman cp "$name-robots:/root/lab.png" "$CORBSLAM_OUT/lab.png"; fi
echo "passed, with $count commands"
