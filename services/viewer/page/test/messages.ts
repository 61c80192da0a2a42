// Short ways to write the messages of tests.
import { type MessageInitShape, create, toBinary } from '@bufbuild/protobuf';
import { WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { decodeMapChange } from '../src/feed/map_change';
import type { MapChange } from '../src/model/map_change';

export const A = 0xaan;
export const B = 0xbbn;
export const HEX_A = '00000000000000aa';
export const HEX_B = '00000000000000bb';

/** A message whose slot 1 is A and slot 2 is B. */
export function change(init: MessageInitShape<typeof WatchMapResponseSchema>): MapChange {
  const message = create(WatchMapResponseSchema, { localMaps: [A, B], localMapAgents: ['alpha', 'beta'], ...init });
  return decodeMapChange(toBinary(WatchMapResponseSchema, message));
}

/** A keyframe that looks ahead, its centre at x. */
export function keyframe(slot: number, index: number, x: number) {
  return {
    id: { slot, index }, timestampNs: BigInt(index),
    cameraFromIsland: { rotationWxyz: [1, 0, 0, 0], translation: [-x, 0, 0] },
  };
}

/** Points of one slot at x = their number. */
export function points(slot: number, numbers: number[]) {
  return {
    ids: { slots: numbers.map(() => slot), indexDeltas: numbers.map((n, i) => BigInt(n - (numbers[i - 1] ?? 0))) },
    positions: numbers.flatMap((n) => [n, 0, 0]),
  };
}
