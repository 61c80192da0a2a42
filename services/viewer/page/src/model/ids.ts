// Names of things, as the wire and people write them.

/** A local map's id as people see it: 16 hexadecimal digits. */
export function hexId(id: bigint): string {
  return BigInt.asUintN(64, id).toString(16).padStart(16, '0');
}

/** The last segment of a resource name. */
export function lastSegment(name: string): string {
  return name.slice(name.lastIndexOf('/') + 1);
}

/** A local map's id, short enough for a label. */
export function shortId(hex: string): string {
  return hex.slice(0, 4);
}

/** One keyframe of the mission. */
export interface KeyframeId {
  localMap: string;
  index: number;
}

/** As a key and as the end of the resource name. */
export function keyframeName(id: KeyframeId): string {
  return `localMaps/${id.localMap}/keyframes/${id.index}`;
}

/** Reads a resource name, whole or without its mission. */
export function parseKeyframeName(name: string): KeyframeId | undefined {
  const match = /(?:^|\/)localMaps\/([0-9a-f]{16})\/keyframes\/(\d{1,10})$/.exec(name);
  return match ? { localMap: match[1], index: Number(match[2]) } : undefined;
}
