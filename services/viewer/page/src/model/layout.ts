// Islands have frames of their own: here they are set side by side on the ground plane.

/** So much is left beside an island for its points, in metres; beside small ones less. */
const MOST_BESIDE = 8;

/** Extent on the ground of one island, in its own frame. */
export interface GroundBox {
  minX: number;
  maxX: number;
  minZ: number;
  maxZ: number;
}

/** What an island was given: room, and where its frame's origin stands. */
export interface Plot extends GroundBox {
  offsetX: number;
  offsetZ: number;
}

/** An island to be placed. */
export interface Placeable {
  name: string;
  isReference: boolean;
  box: GroundBox;
}

/**
 * The reference stands at the origin, the others to its right in the given order. Plots are kept as
 * long as every island fits into its own, so that nothing moves without need. Without points they stand
 * closer.
 */
export function layOut(islands: Placeable[], old: ReadonlyMap<string, Plot>, hasPoints = true): Map<string, Plot> {
  const reference = islands.find(({ isReference }) => isReference) ?? islands[0];
  const same = islands.length === old.size && islands.every(({ name, box }) => fits(box, old.get(name)));
  const stands = reference && old.get(reference.name)?.offsetX === 0;
  if (same && stands) return new Map(old);
  const plots = new Map<string, Plot>();
  const largest = Math.max(0, ...islands.map(({ box }) => extentOf(box)));
  const least = hasPoints ? Math.min(MOST_BESIDE, 3 + 2 * largest) : 0.2 + 0.3 * largest;
  let edge = 0;
  for (const island of [reference, ...islands.filter((other) => other !== reference)]) {
    if (!island) continue;
    const room = widened(island.box, least);
    const isFirst = island === reference;
    const offsetX = isFirst ? 0 : edge - room.minX;
    const offsetZ = isFirst ? 0 : -(room.minZ + room.maxZ) / 2 + middleZ(plots);
    plots.set(island.name, { ...room, offsetX, offsetZ });
    edge = room.maxX + offsetX;
  }
  return plots;
}

function middleZ(plots: Map<string, Plot>): number {
  const [first] = plots.values();
  return first ? (first.minZ + first.maxZ) / 2 : 0;
}

function fits(box: GroundBox, plot: Plot | undefined): boolean {
  return (
    !!plot && box.minX >= plot.minX && box.maxX <= plot.maxX && box.minZ >= plot.minZ && box.maxZ <= plot.maxZ
  );
}

function extentOf(box: GroundBox): number {
  return Math.max(box.maxX - box.minX, box.maxZ - box.minZ);
}

// Points are seen far beside the paths that the boxes are of.
function widened(box: GroundBox, least: number): GroundBox {
  const margin = least + 0.35 * extentOf(box);
  return {
    minX: box.minX - margin, maxX: box.maxX + margin, minZ: box.minZ - margin, maxZ: box.maxZ + margin,
  };
}
