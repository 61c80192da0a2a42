import { type Box3, PerspectiveCamera, Vector3 } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { distanceToSee } from './framing';

const FIELD_OF_VIEW_DEG = 45;
/** Of the height, what tools and the timeline leave. */
const FREE_HEIGHT = 0.84;
const NEAREST_FIT = 2;
/** From so far what was searched is shown with what lies around it. */
const NEAR_LOOK = 40;

/** A camera, its controls, and the part of the page in which they work. */
export class Viewport {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.1, 1e5);
  readonly controls: OrbitControls;
  isTop = false;

  constructor(readonly element: HTMLElement, onChange: () => void) {
    this.controls = new OrbitControls(this.camera, element);
    this.controls.zoomToCursor = true;
    this.controls.maxPolarAngle = Math.PI * 0.499;
    this.controls.listenToKeyEvents(element);
    this.camera.position.set(30, 50, 70);
    this.controls.update();
    this.controls.addEventListener('change', onChange);
  }

  /** Adapts to the element's size. Returns whether it can be seen. */
  resize(): boolean {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0) return false;
    const { left, right } = this.covered();
    const distance = this.distance();
    this.camera.near = Math.max(distance / 1000, 1e-3);
    this.camera.far = distance * 100 + 1000;
    // The middle of the picture is that of what nothing covers. This makes the projection, too.
    this.camera.setViewOffset(clientWidth, clientHeight, (right - left) / 2, 0, clientWidth, clientHeight);
    this.camera.updateMatrixWorld();
    return true;
  }

  distance(): number {
    return this.camera.position.distanceTo(this.controls.target);
  }

  /** Pixels on the screen of one unit at a distance from the camera. */
  pixelsPerUnit(distance: number): number {
    const halfHeight = Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360) * Math.max(distance, this.camera.near);
    return this.element.clientHeight / (2 * halfHeight);
  }

  /** Pixels at the sides over which panels lie; styles say how many. */
  private covered(): { left: number; right: number } {
    const style = getComputedStyle(this.element);
    const pixels = (name: string) => Number.parseFloat(style.getPropertyValue(name)) || 0;
    return { left: pixels('--covered-left'), right: pixels('--covered-right') };
  }

  /** Shows all of a box, from the direction that is looked from now, beside what panels cover. */
  fit(box: Box3): void {
    const { clientWidth, clientHeight } = this.element;
    if (box.isEmpty() || clientWidth === 0 || clientHeight === 0) return;
    const { left, right } = this.covered();
    const up = FREE_HEIGHT * Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
    const aside = (up * Math.max(1, clientWidth - left - right)) / clientHeight;
    const away = this.camera.position.clone().sub(this.controls.target).normalize();
    const distance = distanceToSee(box, away, this.camera.up, aside, up);
    this.look(box.getCenter(new Vector3()), Math.max(distance, NEAREST_FIT));
  }

  /** From above, north (the first camera's view) up, as the paper's figures; or again aslant. */
  setTop(isTop: boolean): void {
    this.isTop = isTop;
    this.controls.maxPolarAngle = isTop ? 0 : Math.PI * 0.499;
    this.controls.minAzimuthAngle = -Infinity;
    const distance = this.distance();
    const aslant = isTop ? new Vector3(0, 1, 1e-4) : new Vector3(0.35, 0.75, 0.9);
    this.camera.position.copy(aslant.setLength(distance).add(this.controls.target));
    this.controls.update();
  }

  /** Keeps a moving point in the middle. */
  follow(point: Vector3): boolean {
    const step = point.clone().sub(this.controls.target);
    if (step.length() < 1e-3) return false;
    step.multiplyScalar(0.15);
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
    return true;
  }

  /** What is looked at, and from where. */
  get pose(): number[] {
    return [...this.controls.target.toArray(), ...this.camera.position.toArray()];
  }

  /** Looks as `pose` said. */
  set pose(pose: number[]) {
    this.controls.target.fromArray(pose, 0);
    this.camera.position.fromArray(pose, 3);
    this.controls.update();
  }

  /** Looks at a place from the direction that is looked from now, near enough to see what is there. */
  approach(place: Vector3): void {
    this.look(place, Math.min(this.distance(), NEAR_LOOK));
  }

  look(middle: Vector3, distance: number): void {
    const direction = this.camera.position.clone().sub(this.controls.target).setLength(distance);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).add(direction);
    this.controls.update();
  }

  /** A point on the element, in its pixels; undefined behind the camera. */
  project(point: Vector3): { x: number; y: number } | undefined {
    const seen = point.clone().applyMatrix4(this.camera.matrixWorldInverse);
    if (seen.z > -this.camera.near) return undefined;
    const clip = seen.applyMatrix4(this.camera.projectionMatrix);
    return {
      x: ((clip.x + 1) / 2) * this.element.clientWidth,
      y: ((1 - clip.y) / 2) * this.element.clientHeight,
    };
  }
}
