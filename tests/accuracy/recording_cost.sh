#!/bin/sh
# recording_cost.sh SOURCE [PAIRS]: what --record costs a robot. Plays SOURCE at the sensor's pace
# without and with it by turns, PAIRS times (3), and prints what a frame's tracking takes (median and
# 99th percentile of a run's frames; the median run, least and most), frames dropped, frames left out
# of the recording, and processor time. CORBSLAM_BIN: where the programs are; CORBSLAM_OUT: where
# recordings and results go, a folder on the disk that is meant.
set -eu

[ $# -ge 1 ] || { echo "usage: recording_cost.sh SOURCE [PAIRS]" >&2; exit 2; }
source=$1
pairs=${2:-3}
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=${CORBSLAM_BIN:-$root/build/release/bin}
out=${CORBSLAM_OUT:-$root/build/recording_cost}
rm -rf "$out"
mkdir -p "$out"

play() {  # NAME FLAGS...
  name=$1
  shift
  "$bin/client_agent" --source "$source" --pace sensor --stats "$out/$name.json" "$@" \
    >"$out/$name.log" 2>&1
}

for pair in $(seq "$pairs"); do
  play "plain_$pair"
  play "recorded_$pair" --record "$out/recording_$pair"
done

python3 - "$out" "$pairs" "$source" <<'TABLE'
import json, statistics, sys

out, pairs, source = sys.argv[1], int(sys.argv[2]), sys.argv[3]

def span(values, digits):
    return "%.*f (%.*f to %.*f)" % (digits, statistics.median(values), digits, min(values), digits,
                                    max(values))

print("| source | run | ms a frame, median | 99th percentile | dropped | left out | processor, s |")
print("| --- | --- | --- | --- | --- | --- | --- |")
for kind in ("plain", "recorded"):
    stats = [json.load(open(f"{out}/{kind}_{pair}.json")) for pair in range(1, pairs + 1)]
    left_out = [json.load(open(f"{out}/recording_{pair}/recording.json"))["counts"]["left_out"]
                for pair in range(1, pairs + 1)] if kind == "recorded" else ["-"]
    print("| %s | %s | %s | %s | %s | %s | %s |" % (
        source, "--record" if kind == "recorded" else "without",
        span([s["tracking_ms"]["median"] for s in stats], 1),
        span([s["tracking_ms"]["p99"] for s in stats], 1),
        ", ".join(str(s["dropped"]) for s in stats), ", ".join(str(n) for n in left_out),
        span([s["cpu_s"] for s in stats], 1)))
TABLE
