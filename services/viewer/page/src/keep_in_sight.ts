import type { Box3 } from 'three';
import { AutoFit } from './auto_fit';
import type { Stage } from './scene/stage';
import type { ViewState } from './view_state';

/** Keeps both layers in sight as they grow and merge, where nobody chose what to look at. */
export class KeepInSight {
  private readonly globalFit = new AutoFit();
  private readonly localFit = new AutoFit();
  private hasChanged = false;

  constructor(private readonly stage: Stage) {
    const { globalPort, localPort } = stage;
    globalPort.controls.addEventListener('start', () => this.globalFit.stop());
    localPort.controls.addEventListener('start', () => this.localFit.stop());
    for (const [{ element }, fit] of [[globalPort, this.globalFit], [localPort, this.localFit]] as const) {
      element.addEventListener('keydown', ({ key }) => void (/^Arrow/.test(key) && fit.stop()));
    }
  }

  /** The map is not what it was. */
  onMap(): void {
    this.hasChanged = true;
  }

  /** Somebody chose where to look from. */
  hold(): void {
    this.globalFit.stop();
  }

  fit(state: ViewState): void {
    const extent = this.extent(state);
    this.globalFit.begin(extent);
    this.stage.globalPort.fit(extent);
    this.fitLocal();
    this.stage.invalidate(true);
  }

  /** Shows what went out of sight; `isPast`: somebody scrubs, and the camera is to stand still. */
  refit(state: ViewState, isPast: boolean): void {
    const now = performance.now();
    if (state.layer !== 'global' && this.localFit.isDue(() => this.stage.local.bounds(), now)) this.fitLocal();
    if (!this.hasChanged || state.follow || isPast || this.stage.map.isMoving) return;
    if (!this.globalFit.isDue(() => this.extent(state), now)) return;
    this.hasChanged = false;
    this.fit(state);
  }

  private fitLocal(): void {
    const bounds = this.stage.local.bounds();
    this.localFit.begin(bounds);
    this.stage.localPort.fit(bounds);
  }

  private extent({ hidden, points }: ViewState): Box3 {
    return this.stage.map.extent(({ agent }) => !hidden.has(agent), points);
  }
}
