import type { Vector3 } from 'three';
import { h, setText } from './panels/dom';
import { distanceText } from './model/place_text';
import { pickPlace } from './scene/picking';
import type { Stage } from './scene/stage';
import type { ViewState } from './view_state';

interface Picked {
  at: Vector3;
  island: string;
}

/** Two clicks on keyframes or points say how far apart they are. */
export class Measure {
  readonly root = h('div', { class: 'measure', role: 'status', 'aria-live': 'polite' });
  isOn = false;
  private readonly places: Picked[] = [];

  constructor(private readonly stage: Stage, private readonly onChange: () => void) {
    this.root.hidden = true;
  }

  toggle(): void {
    this.isOn = !this.isOn;
    this.places.length = 0;
    this.show(this.isOn ? 'Click on a keyframe or a point, then on another one.' : '');
    this.onChange();
  }

  /** A click at a place of the global layer's element. */
  pick(x: number, y: number, { hidden, points }: ViewState): void {
    const picked = pickPlace(this.stage.map, this.stage.globalPort, x, y, points, ({ agent }) => !hidden.has(agent));
    if (!picked) return this.show('There is no keyframe and no point.');
    if (this.places.length === 2) this.places.length = 0;
    this.places.push(picked);
    this.show(this.words());
  }

  /** Islands were moved: what was picked is not there any more. */
  forget(): void {
    if (!this.isOn || this.places.length === 0) return;
    this.places.length = 0;
    this.show('The map has moved. Click on a keyframe or a point, then on another one.');
  }

  private words(): string {
    const [a, b] = this.places;
    if (!b) return 'Now on another one.';
    if (a.island !== b.island) return 'These lie in two islands that nothing connects: how far apart they are is not known.';
    return distanceText(a.at.toArray(), b.at.toArray());
  }

  private show(words: string): void {
    this.root.hidden = words === '';
    setText(this.root, words);
    const [a, b] = this.places;
    const isOne = a?.island === b?.island;
    this.stage.measureView.show(isOne ? a?.at : undefined, b?.at);
    this.stage.invalidate();
  }
}
