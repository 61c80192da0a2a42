// Makes of a folder in KITTI's layout (8-bit grey PNG) what a stereo camera's driver publishes, encoded by Foxglove,
// for dds_peer: OUT has the bytes, OUT.jsonl a line each.
//
//   node make_cdr.mjs FOLDER OUT [--compressed] [--start-s N] [--frames N] [--order]
//
// --order: nothing of the folder, but what asks the robot's services for another local map and a pause.
import { openSync, readFileSync, writeFileSync, writeSync } from "node:fs";
import { inflateSync } from "node:zlib";

import { encode, timeOf } from "./foxglove.mjs";

const [folder, out, ...flags] = process.argv.slice(2);
const value = (flag, instead) => flags.includes(flag) ? Number(flags[flags.indexOf(flag) + 1]) : instead;
const compressed = flags.includes("--compressed");
const start = BigInt(value("--start-s", 1600000000)) * 1000000000n;
const bin = openSync(out, "w");
const lines = [];
let at = 0;

function add(topic, type, ns, message) {
  const bytes = encode(type, message);
  let done = 0;
  while (done < bytes.length) done += writeSync(bin, bytes, done);
  lines.push(JSON.stringify({ topic, type, time_ns: String(ns), offset: at, size: bytes.length }));
  at += bytes.length;
}

// Unpacks a PNG of one channel of 8 bits, not interlaced (ISO 15948).
function pixelsOf(png) {
  const width = png.readUInt32BE(16);
  const height = png.readUInt32BE(20);
  if (png[24] !== 8 || png[25] !== 0 || png[28] !== 0) throw new Error("no grey PNG of 8 bits");
  const packed = [];
  for (let chunk = 8; chunk < png.length; chunk += 12 + png.readUInt32BE(chunk)) {
    const size = png.readUInt32BE(chunk);
    if (png.toString("latin1", chunk + 4, chunk + 8) === "IDAT") packed.push(png.subarray(chunk + 8, chunk + 8 + size));
  }
  const raw = inflateSync(Buffer.concat(packed));
  const pixels = new Uint8Array(width * height);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (width + 1)];
    for (let x = 0; x < width; ++x) {
      const left = x > 0 ? pixels[y * width + x - 1] : 0;
      const up = y > 0 ? pixels[(y - 1) * width + x] : 0;
      const corner = x > 0 && y > 0 ? pixels[(y - 1) * width + x - 1] : 0;
      const guess = left + up - corner;
      const [a, b, c] = [Math.abs(guess - left), Math.abs(guess - up), Math.abs(guess - corner)];
      const paeth = a <= b && a <= c ? left : b <= c ? up : corner;
      pixels[y * width + x] = raw[y * (width + 1) + 1 + x] + [0, left, up, (left + up) >> 1, paeth][filter];
    }
  }
  return { width, height, pixels };
}

function addPicture(side, number, ns, info) {
  const header = { stamp: timeOf(ns), frame_id: side === 0 ? "left" : "right" };
  const png = readFileSync(`${folder}/image_${side}/${String(number).padStart(6, "0")}.png`);
  if (compressed) {
    add(`/camera/${header.frame_id}/image/compressed`, "sensor_msgs/msg/CompressedImage", ns,
        { header, format: "mono8; png compressed", data: new Uint8Array(png) });
  } else {
    const { width, height, pixels } = pixelsOf(png);
    add(`/camera/${header.frame_id}/image`, "sensor_msgs/msg/Image", ns,
        { header, height, width, encoding: "mono8", is_bigendian: 0, step: width, data: pixels });
  }
  add(`/camera/${header.frame_id}/camera_info`, "sensor_msgs/msg/CameraInfo", ns, { ...info, header,
      width: png.readUInt32BE(16), height: png.readUInt32BE(20) });
}

function addFolder() {
  add("/tf_static", "tf2_msgs/msg/TFMessage", start, { transforms: [{
    header: { stamp: timeOf(start), frame_id: "base_link" }, child_frame_id: "left",
    transform: { translation: { x: 0.2, y: 0, z: 0.5 }, rotation: { x: -0.5, y: 0.5, z: -0.5, w: 0.5 } } }] });
  const calibration = new Map(readFileSync(`${folder}/calib.txt`, "utf8").trim().split("\n").map((line) => {
    const [name, ...numbers] = line.trim().split(/\s+/);
    return [name, numbers.map(Number)];
  }));
  const infos = ["P0:", "P1:"].map((name) => {
    const p = calibration.get(name);
    return { distortion_model: "plumb_bob", d: [0, 0, 0, 0, 0], k: [p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]],
             r: [1, 0, 0, 0, 1, 0, 0, 0, 1], p, binning_x: 0, binning_y: 0,
             roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false } };
  });
  const times = readFileSync(`${folder}/times.txt`, "utf8").trim().split("\n").slice(0, value("--frames", 1e9));
  times.forEach((time, number) => {
    const ns = start + BigInt(Math.round(Number(time) * 1e9));
    for (const side of [0, 1]) addPicture(side, number, ns, infos[side]);
  });
}

if (flags.includes("--order")) {
  // The service's topics, as rmw_cyclonedds names them.
  add("dds:rq/visual_slam/pause_mappingRequest", "std_srvs/srv/SetBool_Request", 0n,
      { client: 12345678901234567890n, number: 1n, data: true });
  add("dds:rq/visual_slam/resetRequest", "std_srvs/srv/Trigger_Request", 300000000n,
      { client: 12345678901234567890n, number: 2n, structure_needs_at_least_one_member: 0 });
  add("dds:rq/visual_slam/pause_mappingRequest", "std_srvs/srv/SetBool_Request", 600000000n,
      { client: 12345678901234567890n, number: 3n, data: false });
} else {
  addFolder();
}
writeFileSync(`${out}.jsonl`, lines.join("\n") + "\n");
