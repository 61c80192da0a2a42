// Decodes what dds_peer heard, and says of each topic how many messages came and whether Foxglove encodes
// what it decoded to the same bytes again.
//
//   node decode_cdr.mjs HEARD OUT.jsonl
import { openSync, readFileSync, readSync, writeFileSync } from "node:fs";

import { decode, encode, nanoseconds } from "./foxglove.mjs";

const [heard, out] = process.argv.slice(2);
const file = openSync(heard);
const text = readFileSync(`${heard}.jsonl`, "utf8").trim();
const lines = text === "" ? [] : text.split("\n").map((line) => JSON.parse(line));
const topics = new Map();
const decoded = [];
for (const line of lines) {
  const bytes = new Uint8Array(line.size);
  readSync(file, bytes, 0, line.size, line.offset);
  const value = decode(line.type, bytes);
  // A message is filled up to four bytes, and says in the lowest bits of its options by how many (DDS-XTypes).
  const again = encode(line.type, value);
  const filled = bytes.length - again.length;
  const plain_bytes = bytes.slice(0, again.length);
  plain_bytes[3] &= ~3;
  const same = filled === (bytes[3] & 3) && Buffer.compare(Buffer.from(plain_bytes), Buffer.from(again)) === 0;
  const topic = topics.get(line.topic) ?? { type: line.type, messages: 0, same: 0 };
  topic.messages += 1;
  topic.same += same ? 1 : 0;
  topics.set(line.topic, topic);
  const plain = JSON.stringify(value, (key, field) => {
    if (typeof field === "bigint") return String(field);
    if (field?.sec !== undefined) return String(nanoseconds(field));
    if (ArrayBuffer.isView(field)) return field.length > 64 ? { length: field.length } : Array.from(field, Number);
    return field;
  });
  decoded.push(`{"topic":${JSON.stringify(line.topic)},"time_ns":${JSON.stringify(line.time_ns)},"message":${plain}}`);
}
writeFileSync(out, decoded.join("\n") + "\n");
let good = true;
for (const [name, topic] of topics) {
  console.log(`${name} ${topic.type} ${topic.messages} messages, ${topic.same} to the byte`);
  good &&= topic.same === topic.messages;
}
process.exit(good ? 0 : 1);
