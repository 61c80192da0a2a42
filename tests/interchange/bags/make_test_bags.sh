#!/bin/sh
# make_test_bags.sh FOLDER: writes the bags of tests/data/bags anew, all by writers that are not ours: ROS's own
# library, SQLite, @mcap/core with Foxglove's serialisation. Needs python3-rosbag, python3-sensor-msgs,
# python3-tf2-msgs, python3-numpy, python3-pil, python3-zstandard and lz4 of Debian, and the packages
# @mcap/core, @foxglove/rosmsg, @foxglove/rosmsg-msgs-common, @foxglove/rosmsg2-serialization and
# @foxglove/wasm-zstd of npm, whose node_modules lies in the current folder.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
out=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"
# node looks for packages beside the script.
cp "$here/write_mcap.mjs" "$work/"
ln -s "$PWD/node_modules" "$work/node_modules"
mcap() {
  node "$work/write_mcap.mjs" "$@"
}

"$here/make_messages.py" drawn-stereo - "$work/stereo"
"$here/make_messages.py" drawn-stereo - "$work/png" --png
"$here/make_messages.py" drawn-depth - "$work/depth"
for compression in none bz2 lz4; do
  "$here/write_bag.py" "$work/stereo" "$out/stereo_$compression.bag" $compression
done
"$here/write_bag.py" "$work/depth" "$out/depth.bag"
for compression in none zstd lz4; do
  mcap "$work/stereo" "$out/stereo_$compression.mcap" $compression
done
mcap "$work/stereo" "$out/stereo_unchunked.mcap" none unchunked
mcap "$work/png" "$out/stereo_png.mcap" zstd
mcap "$work/depth" "$out/depth.mcap" zstd
mcap "$work/stereo" "$work/stereo.cdr"
rm -rf "$out/stereo_split" "$out/stereo_packed"
"$here/write_db3.py" "$work/stereo.cdr" "$out/stereo_split" --files 2
"$here/write_db3.py" "$work/stereo.cdr" "$out/stereo_packed" --pack
