// Compares messages of a file with the schemas that Foxglove publishes: names, numbers, types and
// labels of all fields and values, in all messages that they consist of.
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);
const protobuf = require("protobufjs");
const { foxgloveEnumSchemas, foxgloveMessageSchemas, generateProto } =
    require("@foxglove/schemas/internal");

// Returns the published schema of a message as text, or undefined.
function publishedText(name) {
  const schema = foxgloveMessageSchemas[name];
  if (schema === undefined) return undefined;
  const enums = Object.values(foxgloveEnumSchemas).filter((e) => e.parentSchemaName === name);
  return generateProto(schema, enums);
}

function lastName(type) {
  return type.slice(type.lastIndexOf(".") + 1);
}

// Returns lines that say all of a message that decoding depends on, in order.
function describe(type) {
  const fields = type.fieldsArray.map(
      (f) => `${f.id} ${f.repeated ? "repeated " : ""}${f.options?.proto3_optional ? "optional " : ""}` +
             `${lastName(f.type)} ${f.name.replace(/[A-Z]/g, (c) => "_" + c.toLowerCase())}`);
  const enums = type.nestedArray.filter((n) => n instanceof protobuf.Enum)
                    .flatMap((e) => Object.entries(e.values).map(([k, v]) => `${e.name}.${k} = ${v}`));
  return [...fields, ...enums].sort();
}

function compareMessage(type) {
  const text = publishedText(type.name);
  if (text === undefined) throw new Error(`Foxglove publishes no schema ${type.name}`);
  const published = protobuf.parse(text).root.lookupType(`foxglove.${type.name}`);
  const [ours, theirs] = [describe(type), describe(published)];
  if (ours.join("\n") === theirs.join("\n")) return;
  const lines = [...ours.filter((l) => !theirs.includes(l)).map((l) => `  here: ${l}`),
                 ...theirs.filter((l) => !ours.includes(l)).map((l) => `  published: ${l}`)];
  throw new Error(`foxglove.${type.name} is not as it is published:\n${lines.join("\n")}`);
}

// Compares the message of this full name, and all that it consists of.
export function compareWithPublished(name, root) {
  const waiting = [root.lookupType(name)];
  const seen = new Set();
  while (waiting.length > 0) {
    const type = waiting.pop();
    if (seen.has(type.fullName)) continue;
    seen.add(type.fullName);
    if (type.fullName.startsWith(".google.protobuf.")) continue;
    compareMessage(type);
    for (const field of type.fieldsArray) {
      if (field.resolvedType instanceof protobuf.Type) waiting.push(field.resolvedType);
    }
  }
}
