import { BufferAttribute, BufferGeometry, DynamicDrawUsage, type Object3D, Points, type RawShaderMaterial, Vector3 } from 'three';
import type { KeyframeId } from '../model/ids';
import type { SceneColours } from '../model/palette';
import { type Landmark, splitLandmarks } from '../model/sights';
import { Lines } from './lines';
import type { MapView } from './map_view';
import { type SharedUniforms, plainColour, setColour } from './materials';

/** The landmarks that the chosen keyframe sees: over everything, with thin rays from its camera. */
export class SightsView {
  /** So many of those that were asked for are in the picture. */
  shown = 0;
  private readonly points: Points<BufferGeometry, RawShaderMaterial>;
  private readonly rays: Lines;
  private attribute = new BufferAttribute(new Float32Array(0), 3);
  /** Of what it was drawn last. */
  private drawn: unknown[] = [];

  constructor(parent: Object3D, uniforms: SharedUniforms) {
    this.points = new Points(new BufferGeometry(), uniforms.sights());
    this.points.frustumCulled = false;
    this.points.visible = false;
    this.points.renderOrder = 4;
    this.rays = new Lines(uniforms.lines(), 6);
    this.rays.material.depthTest = false;
    this.rays.material.uniforms.widthPx.value = 1;
    this.rays.mesh.renderOrder = 3;
    parent.add(this.points, this.rays.mesh);
  }

  paint({ selected, background }: SceneColours): void {
    setColour(this.points.material, selected);
    plainColour(this.points.material.uniforms.rim.value, background);
    setColour(this.rays.material, selected);
  }

  /** Follows the map. */
  update(map: MapView, camera: KeyframeId | undefined, landmarks: readonly Landmark[]): void {
    const inputs = [map.version, camera, landmarks];
    if (inputs.every((input, i) => input === this.drawn[i])) return;
    this.drawn = inputs;
    const places = camera ? placesOf(map, landmarks) : [];
    this.shown = places.length;
    this.showPoints(places);
    this.showRays(camera && map.world(camera), places);
  }

  private showPoints(places: Vector3[]): void {
    const { geometry } = this.points;
    this.points.visible = places.length > 0;
    if (this.attribute.count < places.length) {
      geometry.dispose();
      this.attribute = new BufferAttribute(new Float32Array(3 * 2 * places.length), 3);
      this.attribute.setUsage(DynamicDrawUsage);
      geometry.setAttribute('position', this.attribute);
    }
    places.forEach((place, i) => place.toArray(this.attribute.array, 3 * i));
    this.attribute.needsUpdate = true;
    geometry.setDrawRange(0, places.length);
  }

  /** Many rays together would hide the map. */
  private showRays(from: Vector3 | undefined, places: Vector3[]): void {
    const array = this.rays.array(places.length);
    if (from) {
      places.forEach((place, i) => {
        from.toArray(array, 6 * i);
        place.toArray(array, 6 * i + 3);
      });
    }
    this.rays.commit(from ? places.length : 0);
    this.rays.material.uniforms.opacity.value = Math.max(0.12, Math.min(0.5, 60 / Math.max(1, places.length)));
  }
}

function placesOf(map: MapView, landmarks: readonly Landmark[]): Vector3[] {
  const { known } = splitLandmarks(landmarks, (id) => map.views.get(id)?.model.points);
  return known.map(({ localMap, position }) =>
    new Vector3(...position).applyMatrix4(map.views.get(localMap)!.placement.matrix).applyMatrix4(map.root.matrixWorld));
}
