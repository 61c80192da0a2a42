import { KeyframeStore } from './keyframe_store';
import { PointStore } from './point_store';

/** One local map: everything in it stands in the frame of its island. */
export interface LocalMapModel {
  readonly id: string;
  /** In the order of arrival, from 0. */
  readonly number: number;
  agent: string;
  /** The local map that names its island. */
  island: string;
  keyframes: KeyframeStore;
  points: PointStore;
}

export function newLocalMap(id: string, number: number): LocalMapModel {
  return { id, number, agent: '', island: id, keyframes: new KeyframeStore(), points: new PointStore() };
}

export function copyLocalMap(from: LocalMapModel): LocalMapModel {
  return { ...from, keyframes: from.keyframes.copy(), points: from.points.copy() };
}
