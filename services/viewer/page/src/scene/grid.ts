import { type Box3, BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Vector3 } from 'three';

const LINES_EACH_WAY = 20;

/** A grid on the ground, under everything, with a round spacing. */
export class Grid {
  readonly object = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  private shown = '';

  constructor() {
    this.object.frustumCulled = false;
    this.object.renderOrder = -1;
  }

  paint(colour: string): void {
    this.object.material.color.set(colour);
  }

  cover(box: Box3): void {
    if (box.isEmpty()) return;
    const size = box.getSize(new Vector3());
    const step = roundStep((1.6 * Math.max(size.x, size.z, 1)) / LINES_EACH_WAY);
    const snap = (v: number) => Math.round(v / step) * step;
    const middle = box.getCenter(new Vector3());
    const [x, z, y] = [snap(middle.x), snap(middle.z), box.min.y - 0.04 * step];
    const key = [x, y.toFixed(1), z, step, Math.ceil(size.x / step), Math.ceil(size.z / step)].join();
    if (key === this.shown) return;
    this.shown = key;
    this.rebuild(x, y, z, step, half(size.x, step), half(size.z, step));
  }

  private rebuild(x: number, y: number, z: number, step: number, nx: number, nz: number): void {
    const at: number[] = [];
    for (let i = -nx; i <= nx; i++) at.push(x + i * step, y, z - nz * step, x + i * step, y, z + nz * step);
    for (let i = -nz; i <= nz; i++) at.push(x - nx * step, y, z + i * step, x + nx * step, y, z + i * step);
    this.object.geometry.dispose();
    this.object.geometry = new BufferGeometry();
    this.object.geometry.setAttribute('position', new BufferAttribute(new Float32Array(at), 3));
  }
}

function half(size: number, step: number): number {
  return Math.ceil((0.7 * size) / step) + 2;
}

/** The nearest of 1, 2 and 5 times a power of ten, not above. */
export function roundStep(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const factor = value / power;
  return power * (factor >= 5 ? 5 : factor >= 2 ? 2 : 1);
}
