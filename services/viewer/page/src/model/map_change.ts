import type { WatchMapResponse } from '@gen/corbslam/v1/map_store_service_pb';

/** Map points as columns. */
export interface PointColumns {
  /** Slots of the message's table; empty: all are in slot 1. */
  slots: Uint32Array;
  indices: Float64Array;
  /** x, y, z of each. */
  positions: Float32Array;
  /** How many keyframes see each, at most 255; undefined: the store does not tell. */
  observations?: Uint8Array;
}

/** A message of the map's stream, with the points of each of its islands apart. */
export interface MapChange {
  message: WatchMapResponse;
  points: (PointColumns | undefined)[];
}
