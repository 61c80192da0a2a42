import { roundStep } from '../scene/grid';
import { h } from './dom';

const LONGEST_PX = 160;

/** A scale that is right at the depth that is looked at. */
export class ScaleBar {
  readonly root = h('div', { class: 'scale', role: 'img' });

  update(pixelsPerUnit: number): void {
    const length = roundStep(LONGEST_PX / pixelsPerUnit);
    const words = length >= 1000 ? `${length / 1000} km` : length >= 1 ? `${length} m` : `${Number((100 * length).toPrecision(2))} cm`;
    if (this.root.textContent !== words) this.root.textContent = words;
    this.root.setAttribute('aria-label', `Scale: ${words}`);
    this.root.style.width = `${Math.round(length * pixelsPerUnit)}px`;
  }
}
