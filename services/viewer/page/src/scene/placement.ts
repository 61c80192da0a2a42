import { Matrix4, Quaternion, Vector3 } from 'three';
import type { Alignment } from '../model/alignment';
import { wantsStillness } from '../motion';

export const BLEND_MS = 800;

/** Where a local map stands in the picture; it moves from one place to the next with an ease. */
export class Placement {
  readonly matrix = new Matrix4();
  private readonly target = new Vector3();
  private readonly startTurn = new Quaternion();
  private readonly startMiddle = new Vector3();
  private startScale = 1;
  private readonly middle = new Vector3();
  private startMs = -Infinity;
  private isPlaced = false;

  get isMoving(): boolean {
    return this.startMs > -Infinity;
  }

  /** Stands at once, or begins to move, so that `middle` (in the map's frame) leads. */
  moveTo(target: Vector3, middle: () => Vector3, nowMs: number): void {
    if (this.isPlaced && target.equals(this.target)) return;
    const from = this.isPlaced ? this.matrix.clone() : undefined;
    this.target.copy(target);
    if (from) this.begin(from, middle(), nowMs);
    else this.matrix.makeTranslation(target);
    this.isPlaced = true;
  }

  /** The map's frame changed: stays where it was seen, and moves to where it is now. */
  reframe(oldFromNew: Alignment | undefined, target: Vector3, middle: () => Vector3, nowMs: number): void {
    const from = this.matrix.clone();
    if (oldFromNew) from.multiply(matrixOf(oldFromNew));
    this.target.copy(target);
    if (!this.isPlaced || !oldFromNew) this.matrix.makeTranslation(target);
    else if (!isNear(from, target, middle())) this.begin(from, middle(), nowMs);
    this.isPlaced = true;
  }

  /** The matrix as of now. Returns whether it moves on. */
  advance(nowMs: number): boolean {
    if (!this.isMoving) return false;
    const t = Math.min(1, (nowMs - this.startMs) / BLEND_MS);
    const eased = t * t * (3 - 2 * t);
    const turn = this.startTurn.clone().slerp(new Quaternion(), eased);
    const scale = Math.exp(Math.log(this.startScale) * (1 - eased));
    const seen = this.startMiddle.clone().lerp(this.middle.clone().add(this.target), eased);
    const origin = seen.sub(this.middle.clone().applyQuaternion(turn).multiplyScalar(scale));
    this.matrix.compose(origin, turn, new Vector3(scale, scale, scale));
    if (t >= 1) this.startMs = -Infinity;
    return true;
  }

  private begin(from: Matrix4, middle: Vector3, nowMs: number): void {
    const scale = new Vector3();
    from.decompose(new Vector3(), this.startTurn, scale);
    this.startScale = Math.max(scale.x, 1e-6);
    this.middle.copy(middle);
    this.startMiddle.copy(middle).applyMatrix4(from);
    this.matrix.copy(from);
    this.startMs = nowMs;
    if (wantsStillness()) this.advance(nowMs + BLEND_MS);
  }
}

function isNear(from: Matrix4, target: Vector3, middle: Vector3): boolean {
  return middle.clone().applyMatrix4(from).distanceTo(middle.clone().add(target)) < 1e-3
    && Math.abs(from.elements[0] + from.elements[5] + from.elements[10] - 3) < 1e-4;
}

function matrixOf({ scale, rotation, translation }: Alignment): Matrix4 {
  return new Matrix4().compose(
    new Vector3(...translation), new Quaternion(...rotation), new Vector3(scale, scale, scale),
  );
}
