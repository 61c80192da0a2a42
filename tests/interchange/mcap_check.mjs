// Reads a recording of `corbslam mission export --format mcap` as programs do that show it, and fails
// where something is not as the specification of MCAP or Foxglove's published schemas say.
//
//   node mcap_check.mjs FILE...
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

import { crc32 } from "@foxglove/crc";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";

import { compareWithPublished } from "./schema_check.mjs";

const require = createRequire(import.meta.url);
const protobuf = require("protobufjs");
require("protobufjs/ext/descriptor");

function expect(holds, what) {
  if (!holds) throw new Error(what);
}

class Bytes {
  constructor(bytes) {
    this.bytes = bytes;
  }
  async size() {
    return BigInt(this.bytes.length);
  }
  async read(offset, length) {
    return this.bytes.subarray(Number(offset), Number(offset + length));
  }
}

// Reads the file from its beginning to its end, with all checksums of chunks.
function readInOrder(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true });
  reader.append(bytes);
  const counts = {};
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
    counts[record.type] = (counts[record.type] ?? 0) + 1;
  }
  expect(reader.done(), "the file goes on behind its end");
  return counts;
}

// The checksum of the data section is of all before DataEnd, whose 13 bytes stand before the summary.
function checkDataCrc(bytes, reader) {
  const summaryStart = Number(reader.footer.summaryStart);
  expect(reader.dataSectionCrc === crc32(bytes.subarray(0, summaryStart - 13)),
         "the checksum of the data section is wrong");
  expect(reader.footer.summaryCrc !== 0, "the summary has no checksum");
}

// Returns a decoder for each schema, made of the schema that the file itself has.
function makeDecoders(reader) {
  const decoders = new Map();
  for (const schema of reader.schemasById.values()) {
    expect(schema.encoding === "protobuf", `${schema.name} is encoded as ${schema.encoding}`);
    const files = protobuf.descriptor.FileDescriptorSet.decode(schema.data);
    const root = protobuf.Root.fromDescriptor(files);
    root.resolveAll();
    compareWithPublished(schema.name, root);
    decoders.set(schema.id, root.lookupType(schema.name));
  }
  return decoders;
}

// Names fields as in JSON: a schema that does not say these names has them with underscores.
function withJsonNames(value) {
  if (Array.isArray(value)) return value.map(withJsonNames);
  if (value === null || typeof value !== "object" || ArrayBuffer.isView(value)) return value;
  return Object.fromEntries(Object.entries(value).map(
      ([key, v]) => [key.replace(/_(.)/g, (_, c) => c.toUpperCase()), withJsonNames(v)]));
}

function nanoseconds(time) {
  return BigInt(time.seconds ?? 0) * 1_000_000_000n + BigInt(time.nanos ?? 0);
}

// Every frame that something lies in must hang from the mission's.
class Frames {
  parents = new Map();
  used = new Set();

  add(transform) {
    expect(transform.childFrameId && transform.parentFrameId, "a frame has no name");
    const known = this.parents.get(transform.childFrameId);
    expect(known === undefined || known === transform.parentFrameId,
           `frame ${transform.childFrameId} has two parents`);
    this.parents.set(transform.childFrameId, transform.parentFrameId);
    const { x, y, z, w } = transform.rotation;
    expect(Math.abs(Math.hypot(x, y, z, w) - 1) < 1e-6, "a rotation is not of length 1");
  }
  check() {
    for (const used of this.used) {
      let frame = used;
      while (frame !== "mission" && this.parents.has(frame)) frame = this.parents.get(frame);
      expect(frame === "mission", `frame ${used} hangs from nothing`);
    }
  }
}

function checkCloud(cloud) {
  expect(cloud.data.length % cloud.pointStride === 0, "a cloud's last point is cut");
  const names = cloud.fields.map((field) => `${field.name}@${field.offset}:${field.type}`);
  expect(names.join(" ") === "x@0:7 y@4:7 z@8:7 red@12:1 green@13:1 blue@14:1 alpha@15:1",
         `a cloud has the fields ${names.join(" ")}`);
}

function checkScene(scene) {
  expect(scene.deletions.length === 1 && scene.deletions[0].type === 1,
         "a scene does not begin with deleting all: who jumps to its time would see too much");
  const ids = new Set(scene.entities.map((entity) => entity.id));
  expect(ids.size === scene.entities.length, "two entities of a scene have one id");
  for (const entity of scene.entities) {
    for (const lines of entity.lines) {
      expect(lines.type === 2 || lines.type === 0, "lines are neither a list nor one line");
      const points = lines.indices.length > 0 ? lines.indices.length : lines.points.length;
      expect(lines.type === 0 || points % 2 === 0, "a line has one end");
      for (const index of lines.indices) expect(index < lines.points.length, "an index is too large");
    }
  }
}

function checkMessage(schema, message, logTime, frames) {
  if (schema === "foxglove.FrameTransforms") message.transforms.forEach((t) => frames.add(t));
  if (schema === "foxglove.FrameTransform") frames.add(message);
  if (schema === "foxglove.PointCloud") checkCloud(message);
  if (schema === "foxglove.SceneUpdate") checkScene(message);
  for (const part of [message, ...(message.entities ?? [])]) {
    if ("frameId" in part) frames.used.add(part.frameId);
  }
  const times = [message, ...(message.entities ?? []), ...(message.transforms ?? [])];
  for (const { timestamp } of times) {
    if (timestamp) expect(nanoseconds(timestamp) === logTime, "a message's own time is another one");
  }
}

async function checkMessages(reader) {
  const decoders = makeDecoders(reader);
  const frames = new Frames();
  const counts = new Map();
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const type = decoders.get(channel.schemaId);
    const decoded = withJsonNames(
        type.toObject(type.decode(message.data), { defaults: true, longs: String }));
    checkMessage(type.fullName.slice(1), decoded, message.logTime, frames);
    expect(message.logTime >= last, "messages do not come in the order of their times");
    last = message.logTime;
    counts.set(channel.id, (counts.get(channel.id) ?? 0) + 1);
  }
  frames.check();
  return counts;
}

function checkStatistics(reader, counts, recordCounts) {
  const statistics = reader.statistics;
  const total = [...counts.values()].reduce((sum, count) => sum + count, 0);
  expect(Number(statistics.messageCount) === total, "the statistics count other messages");
  expect(statistics.channelCount === reader.channelsById.size, "other channels");
  expect(statistics.schemaCount === reader.schemasById.size, "other schemas");
  expect(statistics.chunkCount === reader.chunkIndexes.length, "other chunks");
  expect(statistics.metadataCount === reader.metadataIndexes.length, "other metadata");
  for (const [id, count] of statistics.channelMessageCounts) {
    expect(Number(count) === counts.get(id), `other messages on channel ${id}`);
  }
  expect((recordCounts.Message ?? 0) === total, "the index and the file have other messages");
}

async function check(path) {
  const bytes = readFileSync(path);
  const recordCounts = readInOrder(bytes);
  const reader = await McapIndexedReader.Initialize({ readable: new Bytes(bytes) });
  checkDataCrc(bytes, reader);
  const counts = await checkMessages(reader);
  checkStatistics(reader, counts, recordCounts);
  for await (const metadata of reader.readMetadata()) {
    expect(metadata.name === "corbslam" && metadata.metadata.has("clock"), "metadata say no clock");
  }
  console.log(`${path}: ${reader.statistics.messageCount} messages on ` +
              `${reader.channelsById.size} topics in ${reader.chunkIndexes.length} chunks`);
}

for (const path of process.argv.slice(2)) {
  try {
    await check(path);
  } catch (error) {
    console.error(`${path}: ${error.stack}`);
    process.exitCode = 1;
  }
}
if (process.argv.length < 3) {
  console.error("usage: node mcap_check.mjs FILE...");
  process.exitCode = 2;
}
