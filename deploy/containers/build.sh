#!/bin/sh
# build.sh [OPTION...] [PROGRAM...] [-- ARGUMENT...]: builds the images of map_store, fusion_worker,
# map_viewer and client_agent, or of those named (corbslam, the command, too), with buildah. Arguments go to buildah build, for example
# --isolation chroot --network host where containers get no network of their own.
#
# --binaries DIR   ships the programs in DIR, built on this machine (Debian 12), with its libraries;
#                  without: builds them in a container
# --platform P     linux/amd64 or linux/arm64 (this machine's); another machine's needs --binaries, with the
#                  programs of a cross build (docs/arm64.md)
# --sysroot DIR    the libraries of a cross build (build/arm64_sysroot)
# --base IMAGE     to build on (docker.io/library/debian:bookworm-slim)
# --debootstrap    makes the base with debootstrap first, as localhost/corbslam/base (needs root)
# --prefix NAME    of the images' names (localhost/corbslam)
# --tag TAG        of the images (latest, and the release's number)
set -eu

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
binaries='' platform='' sysroot=$root/build/arm64_sysroot base='' prefix=localhost/corbslam tag=
debootstrap='' programs=''

usage() {
  [ $# -eq 0 ] || echo "build.sh: $*" >&2
  sed -n '2,15s/^# \{0,1\}//p' "$0" >&2
  exit 2
}
while [ $# -gt 0 ] && [ "$1" != -- ]; do
  case $1 in
    --binaries | --platform | --sysroot | --base | --prefix | --tag)
      [ $# -ge 2 ] || usage "$1 needs a value"
      case $1 in
        --binaries) binaries=$2 ;;
        --platform) platform=$2 ;;
        --sysroot) sysroot=$2 ;;
        --base) base=$2 ;;
        --prefix) prefix=$2 ;;
        --tag) tag=$2 ;;
      esac
      shift
      ;;
    --debootstrap) debootstrap=yes ;;
    map_store | fusion_worker | map_viewer | client_agent | corbslam) programs="$programs $1" ;;
    *) usage "no such option or program: $1" ;;
  esac
  shift
done
[ $# -eq 0 ] || shift
: "${programs:=map_store fusion_worker map_viewer client_agent}"

here_is=linux/$(uname -m | sed "s/x86_64/amd64/; s/aarch64/arm64/")
: "${platform:=$here_is}"
collect_from=''
case $platform in
  "$here_is") ;;
  linux/arm64)
    [ -n "$binaries" ] || usage "--platform $platform on $here_is needs --binaries"
    [ -e "$sysroot/.made" ] || usage "$sysroot is nothing that deploy/arm64/make_sysroot.sh made (--sysroot)"
    collect_from=yes
    ;;
  *) usage "--platform $platform: on $here_is there are $here_is and linux/arm64" ;;
esac

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM

# A minimal Debian with the package sources that this machine has.
make_base() {
  debootstrap --variant=minbase bookworm "$work/base" >&2
  for sources in sources.list sources.list.d/debian.sources; do
    if [ -e "/etc/apt/$sources" ]; then cp "/etc/apt/$sources" "$work/base/etc/apt/$sources"; fi
  done
  rm -rf "$work/base/var/cache/apt/archives" "$work/base/var/lib/apt/lists"
  mkdir -p "$work/base/var/cache/apt/archives/partial" "$work/base/var/lib/apt/lists/partial"
  container=$(buildah from scratch)
  buildah add -q "$container" "$work/base" / >&2
  buildah config --cmd /bin/bash "$container"
  buildah commit -q --rm "$container" "$1" >&2
  rm -rf "$work/base"
}

if [ -n "$debootstrap" ]; then
  : "${base:=localhost/corbslam/base:bookworm}"
  make_base "$base"
fi

# The context that stands for the stage "build": what it would have made.
if [ -n "$binaries" ]; then
  mkdir -p "$work/context/roots/state/corbslam" "$work/context/roots/state/corbslam-backups"
  for program in $programs; do
    [ -x "$binaries/$program" ] || usage "--binaries: there is no program $binaries/$program"
    "$here/collect.sh" ${collect_from:+--sysroot "$sysroot"} "$work/context/roots/$program" \
      "$binaries/$program"
  done
  set -- --build-context "build=$work/context" "$@"
else
  # Packages are installed once, and programs built once, for all images.
  set -- --layers --build-arg "JOBS=$(nproc)" "$@"
fi

version=$(sed -n 's/^project(corbslam VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
revision=$(git -C "$root" describe --always --dirty --abbrev=40 2>/dev/null || echo unknown)
for program in $programs; do
  # Of the two image formats docker's is the one that knows HEALTHCHECK.
  buildah build --format docker --platform "$platform" ${base:+--build-arg "BASE=$base"} \
    --build-arg "VERSION=$version" --build-arg "REVISION=$revision" \
    --file "$here/Containerfile" --target "$program" --tag "$prefix/$program:${tag:-latest}" "$@" "$root"
  [ -n "$tag" ] || buildah tag "$prefix/$program:latest" "$prefix/$program:$version"
done
for program in $programs; do
  buildah images --format '{{.Name}}:{{.Tag}} {{.Size}}' "$prefix/$program:${tag:-latest}"
done
