import { Box3, Vector3 } from 'three';

const EVERY_MS = 1000;
/** Of what is shown, what the map may take at least, at most, and by how much its middle may be off. */
const LEAST = 0.5;
const MOST = 1.1;
const FARTHEST = 0.25;

/** Keeps all of a growing map in sight until somebody moves the camera. */
export class AutoFit {
  private fitted = new Box3();
  private lastMs = -Infinity;
  private isOn = true;

  /** Somebody looks where they want to. */
  stop(): void {
    this.isOn = false;
  }

  /** All of a box is shown now, and of those that follow. */
  begin(box: Box3): void {
    this.fitted = box.clone();
    this.isOn = true;
  }

  /** Whether to show all anew; `extent` is asked for not more often than each second. */
  isDue(extent: () => Box3, nowMs: number): boolean {
    if (!this.isOn || nowMs - this.lastMs < EVERY_MS) return false;
    this.lastMs = nowMs;
    return isElsewhere(extent(), this.fitted);
  }
}

/** Whether a box is so much smaller, larger or farther aside that what shows the other one shows it badly. */
export function isElsewhere(now: Box3, fitted: Box3): boolean {
  if (now.isEmpty()) return false;
  if (fitted.isEmpty()) return true;
  const size = fitted.getSize(new Vector3()).length();
  const ratio = now.getSize(new Vector3()).length() / Math.max(size, 1e-6);
  const aside = now.getCenter(new Vector3()).distanceTo(fitted.getCenter(new Vector3()));
  return ratio < LEAST || ratio > MOST || aside > FARTHEST * size;
}
