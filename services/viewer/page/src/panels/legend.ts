import { sceneColours, type Theme } from '../model/palette';
import type { ViewState } from '../view_state';
import { h, setText, swatch } from './dom';

const ENDS: Partial<Record<ViewState['colour'], [string, string]>> = { height: ['low', 'high'], age: ['old', 'new'] };

/** What colours mean that no robot's row says. */
export class Legend {
  readonly root = h('div', { class: 'legend' });
  private shown = '';

  /** `own`: the robot that is drawn as own. */
  update({ colour }: ViewState, theme: Theme, own: string): void {
    const key = [colour, theme, own].join();
    if (key === this.shown) return;
    this.shown = key;
    const colours = sceneColours(theme);
    const ends = ENDS[colour];
    this.root.hidden = !ends && colour !== 'paper';
    if (ends) this.root.replaceChildren(ends[0], this.ramp(colours.ramp), ends[1]);
    else if (colour === 'paper') this.root.replaceChildren(swatch(colours.own), own || 'own', swatch(colours.others), 'others');
    else setText(this.root, '');
  }

  private ramp(colours: string[]): HTMLElement {
    const bar = h('span', { class: 'ramp', 'aria-hidden': 'true' });
    bar.style.backgroundImage = `linear-gradient(to right, ${colours.join()})`;
    return bar;
  }
}
