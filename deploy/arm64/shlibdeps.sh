#!/bin/sh
# shlibdeps.sh [OPTION...] -O PROGRAM...: prints, as dpkg-shlibdeps does for the machine's own programs,
# "shlibs:Depends=" with the packages of the libraries that arm64 programs load, by what these packages'
# `shlibs` say of themselves in CORBSLAM_ARM64_SYSROOT. dpkg-shlibdeps knows no folder that stands for
# another machine. A library of no package is an error.
set -eu

info=${CORBSLAM_ARM64_SYSROOT:?is not set}/var/lib/dpkg/info
while [ $# -gt 0 ]; do
  case $1 in
    -*) shift ;;
    *) break ;;
  esac
done
[ $# -gt 0 ] || { sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2; }

# Both forms of a name: libNAME.so.VERSION and libNAME-VERSION.so.
readelf --dynamic "$@" | sed -n 's/.*(NEEDED).*\[\(.*\)\]$/\1/p' | sort -u |
  sed 's/^\(.*\)\.so\.\(.*\)$/& \1 \2/; t; s/^\(.*\)-\([^-]*\)\.so$/& \1 \2/' |
  awk -v said="$(cat "$info"/*.shlibs)" '
    BEGIN {
      count = split(said, lines, "\n")
      for (i = 1; i <= count; ++i) {
        if (lines[i] ~ /^[a-z]+: / || lines[i] ~ /^#/) continue  # Of the installer alone.
        split(lines[i], part, " ")
        text = lines[i]
        sub(/^[^ ]+ +[^ ]+ +/, "", text)
        of[part[1] " " part[2]] = text
      }
    }
    !(($2 " " $3) in of) { print "shlibdeps.sh: " $1 " is of no package" > "/dev/stderr"; failed = 1; next }
    { count = split(of[$2 " " $3], each, ", *"); for (i = 1; i <= count; ++i) wanted[each[i]] = 1 }
    END {
      if (failed) exit 1
      for (package in wanted) print package
    }' | sort | paste -sd, | sed 's/,/, /g; s/^/shlibs:Depends=/'
