// Decodes WatchMapResponse. Its points are most of it: they are read into typed arrays here, the rest
// by the generated code, for which a million 64-bit integers would be a million objects.
import { fromBinary } from '@bufbuild/protobuf';
import { type WatchMapResponse, WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import type { MapChange, PointColumns } from '../model/map_change';
import { WireReader, forEachField, joinBytes, lengthDelimited } from './wire';

const RESPONSE_ISLANDS = WatchMapResponseSchema.field.islands.number;
const ISLAND = WatchMapResponseSchema.field.islands.message!.field;
const [POINTS_IDS, POINTS_POSITIONS] = [1, 2];
const [IDS_SLOTS, IDS_DELTAS] = [1, 2];

export function decodeMapChange(bytes: Uint8Array): MapChange {
  const points: (PointColumns | undefined)[] = [];
  const reader = new WireReader(bytes);
  const rest: Uint8Array[] = [];
  forEachField(reader, (field, wireType, begin) => {
    if (field === RESPONSE_ISLANDS && wireType === 2) {
      const island = splitIsland(reader.part());
      points.push(island.points);
      rest.push(lengthDelimited(RESPONSE_ISLANDS, island.rest));
    } else {
      reader.skip(wireType);
      rest.push(bytes.subarray(begin, reader.at));
    }
  });
  const message: WatchMapResponse = fromBinary(WatchMapResponseSchema, joinBytes(rest));
  return { message, points };
}

function splitIsland(reader: WireReader): { rest: Uint8Array; points: PointColumns | undefined } {
  const rest: Uint8Array[] = [];
  let points: PointColumns | undefined;
  const observations: number[] = [];
  forEachField(reader, (field, wireType, begin) => {
    if (field === ISLAND.points.number && wireType === 2) points = readPoints(reader.part());
    else if (field === ISLAND.pointObservations.number && wireType === 2) readCounts(reader.part(), observations);
    else {
      reader.skip(wireType);
      rest.push(reader.bytes.subarray(begin, reader.at));
    }
  });
  // One for each point; anything else could be of other points.
  if (points && observations.length > 0 && observations.length === points.indices.length) {
    points.observations = Uint8Array.from(observations);
  }
  return { rest: joinBytes(rest), points };
}

/** Counts of 255 and more are one. */
function readCounts(reader: WireReader, counts: number[]): void {
  while (!reader.isDone) counts.push(Math.min(255, reader.varint()));
}

function readPoints(reader: WireReader): PointColumns {
  const columns: PointColumns = { slots: new Uint32Array(0), indices: new Float64Array(0), positions: new Float32Array(0) };
  forEachField(reader, (field, wireType) => {
    if (field === POINTS_IDS && wireType === 2) readIds(reader.part(), columns);
    else if (field === POINTS_POSITIONS && wireType === 2) columns.positions = floats(reader.part().content);
    else reader.skip(wireType);
  });
  return columns;
}

function readIds(reader: WireReader, columns: PointColumns): void {
  forEachField(reader, (field, wireType) => {
    if (field === IDS_SLOTS && wireType === 2) columns.slots = Uint32Array.from(packed(reader.part(), false));
    else if (field === IDS_DELTAS && wireType === 2) columns.indices = sums(packed(reader.part(), true));
    else reader.skip(wireType);
  });
}

function packed(reader: WireReader, isZigzag: boolean): Float64Array {
  const values = new Float64Array(reader.end - reader.at);
  let count = 0;
  while (!reader.isDone) values[count++] = isZigzag ? reader.zigzag() : reader.varint();
  return values.slice(0, count);
}

function sums(deltas: Float64Array): Float64Array {
  for (let i = 1; i < deltas.length; i++) deltas[i] += deltas[i - 1];
  return deltas;
}

/** The wire's floats have their least significant byte first, as every machine that has WebGL. */
function floats(content: Uint8Array): Float32Array {
  return new Float32Array(content.slice().buffer, 0, content.length >> 2);
}
