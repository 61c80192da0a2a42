import type { Message } from '@bufbuild/protobuf';
import type { WatchMapResponse_IslandKeyframe } from '@gen/corbslam/v1/map_store_service_pb';
import { DirtyPages } from './dirty_pages';
import type { Pose } from './pose';

/** What a keyframe is told to be, beside which it is and where it stands. */
type KeyframeTold = Omit<WatchMapResponse_IslandKeyframe, keyof Message | 'id' | 'cameraFromIsland' | 'parent'>;

/** What is kept of a keyframe beside the columns that the GPU reads: all that was told of it. */
export interface KeyframeRecord extends KeyframeTold {
  slot: number;
  generation: number;
}

/** The keyframes of one local map: columns for the GPU, records for people. */
export class KeyframeStore {
  /** x, y, z of the camera's centre and the order of arrival, for each slot. */
  centres = new Float32Array(64 * 4);
  /** island_from_camera as x, y, z, w, for each slot. */
  rotations = new Float32Array(64 * 4);
  indices = new Uint32Array(64);
  readonly records = new Map<number, KeyframeRecord>();
  readonly dirty = new DirtyPages(64);
  edits = 0;
  private order: number[] = [];
  private orderEdits = -1;
  private membership = 0;

  get count(): number {
    return this.records.size;
  }

  set(index: number, { pose, ...told }: KeyframeTold & { pose: Pose }, age: number, generation: number): boolean {
    const old = this.records.get(index);
    const slot = old?.slot ?? this.newSlot(index);
    this.records.set(index, { ...told, slot, generation });
    this.write(slot, pose, old ? this.centres[slot * 4 + 3] : age);
    if (!old) this.append(slot, told.timestampNs);
    else if (old.timestampNs !== told.timestampNs) this.membership++;
    return !old;
  }

  remove(index: number): boolean {
    const record = this.records.get(index);
    if (!record) return false;
    this.records.delete(index);
    const last = this.records.size;
    if (record.slot !== last) this.moveSlot(last, record.slot);
    this.membership++;
    this.edits++;
    return true;
  }

  sweep(generation: number): void {
    for (const [index, record] of [...this.records]) {
      if (record.generation < generation) this.remove(index);
    }
  }

  pose(index: number): Pose | undefined {
    const record = this.records.get(index);
    if (!record) return undefined;
    const at = record.slot * 4;
    const [x, y, z] = this.centres.subarray(at, at + 3);
    const [qx, qy, qz, qw] = this.rotations.subarray(at, at + 4);
    return { centre: [x, y, z], rotation: [qx, qy, qz, qw] };
  }

  /** Slots in the order of their pictures' time. */
  slotsByTime(): readonly number[] {
    if (this.orderEdits !== this.membership) {
      const records = [...this.records.values()];
      records.sort((a, b) => (a.timestampNs < b.timestampNs ? -1 : a.timestampNs > b.timestampNs ? 1 : 0));
      this.order = records.map((record) => record.slot);
      this.orderEdits = this.membership;
    }
    return this.order;
  }

  /** The index of the newest keyframe. */
  newest(): number | undefined {
    const slot = this.slotsByTime().at(-1);
    return slot === undefined ? undefined : this.indices[slot];
  }

  copy(): KeyframeStore {
    const other = new KeyframeStore();
    other.centres = this.centres.slice();
    other.rotations = this.rotations.slice();
    other.indices = this.indices.slice();
    for (const [index, record] of this.records) other.records.set(index, { ...record });
    return other;
  }

  /** What is newer than all others leaves their order as it is. */
  private append(slot: number, timestampNs: bigint): void {
    const isOrdered = this.orderEdits === this.membership;
    this.membership++;
    const last = this.order.at(-1);
    const isNewest = last === undefined || this.records.get(this.indices[last])!.timestampNs <= timestampNs;
    if (!isOrdered || !isNewest) return;
    this.order.push(slot);
    this.orderEdits = this.membership;
  }

  private newSlot(index: number): number {
    const slot = this.records.size;
    if (slot === this.indices.length) this.grow();
    this.indices[slot] = index;
    return slot;
  }

  private write(slot: number, pose: Pose, age: number): void {
    this.centres.set([...pose.centre, age], slot * 4);
    this.rotations.set(pose.rotation, slot * 4);
    this.dirty.mark(slot);
    this.edits++;
  }

  private moveSlot(from: number, to: number): void {
    this.centres.copyWithin(to * 4, from * 4, from * 4 + 4);
    this.rotations.copyWithin(to * 4, from * 4, from * 4 + 4);
    this.indices[to] = this.indices[from];
    this.records.get(this.indices[to])!.slot = to;
    this.dirty.mark(to);
  }

  private grow(): void {
    const { centres, rotations, indices } = this;
    (this.centres = new Float32Array(centres.length * 2)).set(centres);
    (this.rotations = new Float32Array(rotations.length * 2)).set(rotations);
    (this.indices = new Uint32Array(indices.length * 2)).set(indices);
  }
}
