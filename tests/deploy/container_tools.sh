# shellcheck shell=sh
# For tests that run containers; to be read by a shell.

# skip WHY...: ends the test as skipped.
skip() {
  echo "skipped: $*" >&2
  exit 77
}

# need TOOL...: skips without them, or without root, whom networks of containers need.
need() {
  for tool in "$@"; do
    command -v "$tool" >/dev/null ||
      skip "$tool is not installed (deploy/packages_containers.txt)"
  done
  [ "$(id -u)" -eq 0 ] || skip "a network of containers needs root"
}
