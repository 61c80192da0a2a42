// Writes messages of make_messages.py as ROS 2 would: with Foxglove's serialisation, in MCAP of @mcap/core,
// or as bare CDR for write_db3.py.
//
//   node write_mcap.mjs MESSAGES FILE.mcap [none|zstd|lz4] [unchunked]
//   node write_mcap.mjs MESSAGES FILE.cdr
import { execFileSync } from "node:child_process";
import { openSync, readFileSync, readSync, writeSync } from "node:fs";
import { createRequire } from "node:module";

import { McapWriter } from "@mcap/core";

const require = createRequire(import.meta.url);
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const { stringify } = require("@foxglove/rosmsg");

const [messages, out, compression = "none", ...words] = process.argv.slice(2);
const bin = openSync(`${messages}.bin`);

// Returns the definitions of a type and of what it holds.
function definitionsOf(type, known = new Map()) {
  if (known.has(type)) return [...known.values()];
  const definition = ros2humble[type];
  if (definition === undefined) throw new Error(`no definition of ${type}`);
  known.set(type, { ...definition, name: known.size === 0 ? undefined : type });
  for (const field of definition.definitions) if (field.isComplex) definitionsOf(field.type, known);
  return [...known.values()];
}

// The package names types without the "msg" that ROS 2 has between.
function plainType(type) {
  return type === "TFMessage" ? "tf2_msgs/TFMessage" : `sensor_msgs/${type}`;
}

function fullType(type) {
  return plainType(type).replace("/", "/msg/");
}

const writers = new Map();
function writerOf(type) {
  if (!writers.has(type)) {
    const definitions = definitionsOf(plainType(type));
    writers.set(type, { writer: new MessageWriter(definitions), text: stringify(definitions) });
  }
  return writers.get(type);
}

function timeOf(ns) {
  const whole = BigInt(ns);
  return { sec: Number(whole / 1000000000n), nanosec: Number(whole % 1000000000n) };
}

function valueOf(line) {
  if (line.type === "TFMessage") {
    return { transforms: line.transforms.map((t) => ({
      header: { stamp: timeOf(line.stamp_ns), frame_id: t.parent }, child_frame_id: t.child,
      transform: { translation: t.translation, rotation: t.rotation } })) };
  }
  const value = { header: { stamp: timeOf(line.stamp_ns), frame_id: line.frame_id } };
  if (line.size !== undefined) {
    value.data = new Uint8Array(line.size);
    readSync(bin, value.data, 0, line.size, line.offset);
  }
  if (line.type === "CompressedImage") return { ...value, format: line.format };
  if (line.type === "Image") {
    return { ...value, height: line.height, width: line.width, encoding: line.encoding,
             is_bigendian: line.is_bigendian ?? 0, step: line.step };
  }
  return { ...value, height: line.height, width: line.width, distortion_model: line.distortion_model,
           d: line.D, k: line.K, r: line.R, p: line.P, binning_x: line.binning_x ?? 0, binning_y: line.binning_y ?? 0,
           roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false, ...line.roi } };
}

class File {
  constructor(path) {
    this.file = openSync(path, "w");
    this.at = 0n;
  }
  position() {
    return this.at;
  }
  async write(bytes) {
    let done = 0;
    while (done < bytes.length) done += writeSync(this.file, bytes, done);
    this.at += BigInt(bytes.length);
  }
}

async function packer() {
  if (compression === "zstd") {
    const zstd = require("@foxglove/wasm-zstd");
    await zstd.isLoaded;
    return (data) => ({ compression: "zstd", compressedData: new Uint8Array(zstd.compress(data, 3)) });
  }
  if (compression === "lz4") {
    // Foxglove's package only unpacks; Debian's program lz4 packs.
    return (data) => ({ compression: "lz4", compressedData:
      new Uint8Array(execFileSync("lz4", ["-c", "-q"], { input: data, maxBuffer: 1 << 28 })) });
  }
  return undefined;
}

const lines = readFileSync(`${messages}.jsonl`, "utf8").trim().split("\n").map((line) => JSON.parse(line));
if (out.endsWith(".cdr")) {
  const file = new File(out);
  const index = new File(`${out}.jsonl`);
  for (const line of lines) {
    const cdr = writerOf(line.type).writer.writeMessage(valueOf(line));
    await index.write(Buffer.from(JSON.stringify({ topic: line.topic, type: fullType(line.type),
      time_ns: line.time_ns, offset: Number(file.at), size: cdr.length }) + "\n"));
    await file.write(cdr);
  }
} else {
  const compressChunk = await packer();
  const writer = new McapWriter({ writable: new File(out), compressChunk, useChunks: !words.includes("unchunked") });
  await writer.start({ profile: "ros2", library: "interchange" });
  const channels = new Map();
  let sequence = 0;
  for (const line of lines) {
    const { writer: serialiser, text } = writerOf(line.type);
    if (!channels.has(line.topic)) {
      const schemaId = await writer.registerSchema({ name: fullType(line.type), encoding: "ros2msg",
                                                     data: Buffer.from(text) });
      channels.set(line.topic, await writer.registerChannel({ schemaId, topic: line.topic, messageEncoding: "cdr",
                                                              metadata: new Map() }));
    }
    await writer.addMessage({ channelId: channels.get(line.topic), sequence: sequence++, logTime: BigInt(line.time_ns),
                              publishTime: BigInt(line.stamp_ns), data: serialiser.writeMessage(valueOf(line)) });
  }
  await writer.end();
}
