import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Matrix4, Quaternion, Vector3 } from 'three';
import type { KeyframeId } from '../model/ids';
import { FRUSTUM } from './keyframe_tile';
import type { MapView } from './map_view';

/** A large frustum around the chosen keyframe. */
export class Marker {
  readonly object: LineSegments<BufferGeometry, LineBasicMaterial>;

  constructor() {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(FRUSTUM, 3));
    this.object = new LineSegments(geometry, new LineBasicMaterial({ depthTest: false }));
    this.object.matrixAutoUpdate = false;
    this.object.frustumCulled = false;
    this.object.renderOrder = 3;
    this.object.visible = false;
  }

  paint(colour: string): void {
    this.object.material.color.set(colour);
  }

  update(map: MapView, id: KeyframeId | undefined, size: number): void {
    const view = id && map.views.get(id.localMap);
    const pose = id && view?.model.keyframes.pose(id.index);
    this.object.visible = !!pose;
    if (!view || !pose) return;
    const local = new Matrix4().compose(
      new Vector3(...pose.centre), new Quaternion(...pose.rotation), new Vector3(size, size, size),
    );
    this.object.matrix.multiplyMatrices(map.root.matrixWorld, view.placement.matrix).multiply(local);
    this.object.matrixWorldNeedsUpdate = true;
  }
}
