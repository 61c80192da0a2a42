import type { WatchMapResponse_Island } from '@gen/corbslam/v1/map_store_service_pb';
import { type Alignment, alignPoses } from './alignment';
import { type KeyframeId, hexId } from './ids';
import { forEachItem } from './item_columns';
import { type LocalMapModel, copyLocalMap, newLocalMap } from './local_map';
import type { MapChange, PointColumns } from './map_change';
import { type Pose, poseOfCamera } from './pose';
import { byName } from './robot_numbers';

/** A local map went to another island: old_from_new says where its keyframes stood before. */
export interface IslandChange {
  localMap: string;
  oldFromNew: Alignment | undefined;
}

/**
 * The map as the store tells it. What is to be forgotten goes only when a change is complete, so
 * that what comes again right away is never missing in between.
 */
export class MapModel {
  readonly localMaps = new Map<string, LocalMapModel>();
  globalIsland: string | undefined;
  revision = 0n;
  keyframeCount = 0;
  pointCount = 0;
  /** Arrivals so far; ages are shown relative to them. */
  keyframeArrivals = 0;
  pointArrivals = 0;
  /** Local maps that came so far; one that went leaves its number unused. */
  private arrivals = 0;
  private generation = 1;
  private readonly stale = new Map<string, number>();
  private readonly left = new Map<string, Map<number, Pose>>();

  /** Forgets everything once the next change is complete. */
  reset(): void {
    for (const localMap of this.localMaps.values()) this.markStale(localMap);
  }

  /** Applies messages of one change; the last one of a complete change sweeps. */
  apply(changes: MapChange[]): IslandChange[] {
    for (const change of changes) this.applyOne(change);
    if (changes.at(-1)?.message.continues) return [];
    this.sweep();
    return this.takeIslandChanges();
  }

  localMap(id: string): LocalMapModel | undefined {
    return this.localMaps.get(id);
  }

  pose(id: KeyframeId): Pose | undefined {
    return this.localMaps.get(id.localMap)?.keyframes.pose(id.index);
  }

  /** Islands by the name of the local map that names them, with their local maps by arrival. */
  islands(): Map<string, LocalMapModel[]> {
    const islands = new Map<string, LocalMapModel[]>();
    for (const localMap of this.localMaps.values()) {
      const members = islands.get(localMap.island);
      if (members) members.push(localMap);
      else islands.set(localMap.island, [localMap]);
    }
    return islands;
  }

  /** The islands of an agent's local maps, by their arrival. */
  islandsOf(agent: string): string[] {
    return [...this.localMaps.values()].filter((one) => one.agent === agent).map(({ island }) => island);
  }

  /** Of so many points it was told how many keyframes see them. */
  get observedPoints(): number {
    return [...this.localMaps.values()].reduce((sum, { points }) => sum + points.observed, 0);
  }

  /** The agents' names in the order of their arrival. */
  agents(): string[] {
    return [...new Set([...this.localMaps.values()].map((localMap) => localMap.agent))].filter(Boolean).sort(byName);
  }

  copy(): MapModel {
    const other = new MapModel();
    for (const [id, localMap] of this.localMaps) other.localMaps.set(id, copyLocalMap(localMap));
    const { globalIsland, revision, keyframeCount, pointCount, keyframeArrivals, pointArrivals } = this;
    return Object.assign(other, {
      globalIsland, revision, keyframeCount, pointCount, keyframeArrivals, pointArrivals,
      generation: this.generation, arrivals: this.arrivals,
    });
  }

  private applyOne({ message, points }: MapChange): void {
    const table = message.localMaps.map(hexId);
    table.forEach((id, i) => this.learnAgent(id, message.localMapAgents[i] ?? ''));
    for (const slot of message.removedIslandSlots) this.forgetIsland(table[slot - 1]);
    message.islands.forEach((island, i) => this.applyIsland(island, points[i], table));
    this.revision = message.revision;
  }

  private learnAgent(id: string, agent: string): void {
    const localMap = this.localMaps.get(id);
    if (localMap && agent) localMap.agent = agent;
    else if (!localMap) {
      const created = newLocalMap(id, this.arrivals++);
      created.agent = agent;
      this.localMaps.set(id, created);
    }
  }

  private applyIsland(island: WatchMapResponse_Island, points: PointColumns | undefined, table: string[]): void {
    const name = table[island.slot - 1];
    if (name === undefined) return;
    if (island.anew) this.forgetIsland(name);
    if (island.inGlobalFrame) this.globalIsland = name;
    else if (this.globalIsland === name) this.globalIsland = undefined;
    for (const slot of island.localMapSlots) this.join(table[slot - 1], name);
    this.removeItems(island, table);
    this.setKeyframes(island, table, name);
    if (points) this.setPoints(points, table, name);
  }

  private setKeyframes(island: WatchMapResponse_Island, table: string[], name: string): void {
    for (const { id, cameraFromIsland, parent, ...told } of island.keyframes) {
      const localMap = id && this.join(table[id.slot - 1], name);
      const pose = poseOfCamera(cameraFromIsland);
      if (!localMap || !pose) continue;
      const isNew = localMap.keyframes.set(id.index, { ...told, pose }, this.keyframeArrivals, this.generation);
      if (isNew) this.keyframeArrivals++, this.keyframeCount++;
    }
  }

  private setPoints({ slots, indices, positions, observations }: PointColumns, table: string[], name: string): void {
    const count = Math.min(indices.length, Math.floor(positions.length / 3));
    const members: (LocalMapModel | undefined)[] = [];
    for (let i = 0; i < count; i++) {
      const slot = slots.length > 0 ? slots[i] : 1;
      const localMap = (members[slot - 1] ??= this.join(table[slot - 1], name));
      if (!localMap || !isIndex(indices[i])) continue;
      const at = 3 * i;
      const isNew = localMap.points.set(
        indices[i], positions[at], positions[at + 1], positions[at + 2], this.pointArrivals, this.generation,
        // What no keyframe sees is told, too.
        observations ? Math.max(1, observations[i]) : 0);
      if (isNew) this.pointArrivals++, this.pointCount++;
    }
  }

  private removeItems(island: WatchMapResponse_Island, table: string[]): void {
    for (const { slot, index } of island.removedKeyframes) {
      if (this.localMaps.get(table[slot - 1])?.keyframes.remove(index)) this.keyframeCount--;
    }
    forEachItem(island.removedPoints, (slot, index) => {
      if (this.localMaps.get(table[slot - 1])?.points.remove(index)) this.pointCount--;
    });
  }

  /** Makes a local map part of an island. What it holds was told in the old island's frame. */
  private join(id: string | undefined, island: string): LocalMapModel | undefined {
    const localMap = id === undefined ? undefined : this.localMaps.get(id);
    if (!localMap || localMap.island === island) return localMap;
    if (localMap.keyframes.count > 0) {
      if (!this.left.has(localMap.id)) this.left.set(localMap.id, posesOf(localMap));
      if (!this.stale.has(localMap.id)) this.markStale(localMap);
    }
    localMap.island = island;
    return localMap;
  }

  private forgetIsland(name: string | undefined): void {
    for (const localMap of this.localMaps.values()) {
      if (localMap.island === name) this.markStale(localMap);
    }
  }

  private markStale(localMap: LocalMapModel): void {
    if (localMap.keyframes.count + localMap.points.count === 0) return;
    this.stale.set(localMap.id, ++this.generation);
    if (!this.left.has(localMap.id)) this.left.set(localMap.id, posesOf(localMap));
  }

  private sweep(): void {
    for (const [id, generation] of this.stale) {
      const localMap = this.localMaps.get(id);
      if (!localMap) continue;
      const { keyframes, points } = localMap;
      const before = [keyframes.count, points.count];
      keyframes.sweep(generation);
      points.sweep(generation);
      this.keyframeCount -= before[0] - keyframes.count;
      this.pointCount -= before[1] - points.count;
      if (keyframes.count + points.count === 0) this.localMaps.delete(id);
    }
    this.stale.clear();
  }

  private takeIslandChanges(): IslandChange[] {
    const changes: IslandChange[] = [];
    for (const [id, old] of this.left) {
      const now = this.localMaps.get(id)?.keyframes;
      const common = [...old.keys()].filter((index) => now?.records.has(index));
      const target = common.map((index) => old.get(index)!);
      const source = common.map((index) => now!.pose(index)!);
      changes.push({ localMap: id, oldFromNew: alignPoses(source, target) });
    }
    this.left.clear();
    return changes;
  }
}

function posesOf({ keyframes }: LocalMapModel): Map<number, Pose> {
  return new Map([...keyframes.records.keys()].map((index) => [index, keyframes.pose(index)!]));
}

function isIndex(index: number): boolean {
  return index >= 0 && index < 0xffffffff;
}
