// ROS 2's messages by Foxglove's packages.
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const { parse } = require("@foxglove/rosmsg");

// What the packages don't know, as ROS 2's own files have it (from Iron on; Humble's ids have 24 bytes).
const own = {
  "rmw_dds_common/ParticipantEntitiesInfo": `rmw_dds_common/Gid gid
rmw_dds_common/NodeEntitiesInfo[] node_entities_info_seq
===
MSG: rmw_dds_common/Gid
uint8[16] data
===
MSG: rmw_dds_common/NodeEntitiesInfo
string node_namespace
string node_name
rmw_dds_common/Gid[] reader_gid_seq
rmw_dds_common/Gid[] writer_gid_seq`,
  // With what rmw_cyclonedds puts before each.
  "std_srvs/Trigger_Request": "uint64 client\nint64 number\nuint8 structure_needs_at_least_one_member",
  "std_srvs/Trigger_Response": "uint64 client\nint64 number\nbool success\nstring message",
  "std_srvs/SetBool_Request": "uint64 client\nint64 number\nbool data",
  "std_srvs/SetBool_Response": "uint64 client\nint64 number\nbool success\nstring message",
};

function definitionsOf(type, known = new Map()) {
  if (own[type] !== undefined) return parse(own[type], { ros2: true });
  if (known.has(type)) return [...known.values()];
  const definition = ros2humble[type];
  if (definition === undefined) throw new Error(`no definition of ${type}`);
  known.set(type, { ...definition, name: known.size === 0 ? undefined : type });
  for (const field of definition.definitions) if (field.isComplex) definitionsOf(field.type, known);
  return [...known.values()];
}

// "sensor_msgs/msg/Image", "std_srvs/srv/Trigger_Request".
const plain = (type) => type.replace(/\/(msg|srv)\//, "/");
const cache = new Map();
function coderOf(type) {
  if (!cache.has(type)) {
    const definitions = definitionsOf(plain(type));
    cache.set(type, { reader: new MessageReader(definitions), writer: new MessageWriter(definitions) });
  }
  return cache.get(type);
}

export const encode = (type, value) => coderOf(type).writer.writeMessage(value);
export const decode = (type, bytes) => coderOf(type).reader.readMessage(bytes);
export function timeOf(ns) {
  const whole = BigInt(ns);
  return { sec: Number(whole / 1000000000n), nanosec: Number(whole % 1000000000n) };
}
// Foxglove's readers call it nsec.
export const nanoseconds = (time) => BigInt(time.sec) * 1000000000n + BigInt(time.nanosec ?? time.nsec);
