import { FEW_OBSERVATIONS, MANY_OBSERVATIONS, sceneColours, type Theme } from '../model/palette';
import { count } from '../model/texts';
import type { ViewState } from '../view_state';
import { h, setText, swatch } from './dom';

/** Of how many of a map's points it is known how many keyframes see them. */
export interface Observed {
  pointCount: number;
  observedPoints: number;
}

/** What colours mean that no robot's row says. */
export class Legend {
  readonly root = h('div', { class: 'legend' });
  private shown = '';

  /** `own`: the robot that is drawn as own. */
  update({ colour }: ViewState, theme: Theme, own: string, map: Observed, heights: [number, number] = [0, 0]): void {
    const untold = colour === 'observations' ? untoldText(map) : '';
    const ends = endsOf(colour, heights, map.pointCount);
    const key = [colour, theme, own, untold, ends].join();
    if (key === this.shown) return;
    this.shown = key;
    const colours = sceneColours(theme);
    this.root.hidden = !ends && colour !== 'paper' && colour !== 'observations';
    if (ends) this.root.replaceChildren(ends[0], this.ramp(colours.ramp), ends[1]);
    else if (colour === 'observations') this.root.replaceChildren(...this.observations(colours.ramp, map, untold));
    else if (colour === 'paper') this.root.replaceChildren(swatch(colours.own), own || 'own', swatch(colours.others), 'others');
    else setText(this.root, '');
  }

  /** The ramp's numbers stand where their colours are. */
  private observations(ramp: string[], map: Observed, untold: string): (Node | string)[] {
    if (isUntold(map)) return [untold];
    const middle = Math.round(Math.sqrt(FEW_OBSERVATIONS * MANY_OBSERVATIONS));
    const parts = [
      `points that ${FEW_OBSERVATIONS} or fewer`, this.ramp(ramp.slice(0, 2)), String(middle), this.ramp(ramp.slice(1)),
      `${MANY_OBSERVATIONS} or more keyframes see`,
    ];
    return untold ? [...parts, `· ${untold}`] : parts;
  }

  private ramp(colours: string[]): HTMLElement {
    const bar = h('span', { class: colours.length > 2 ? 'ramp' : 'ramp half', 'aria-hidden': 'true' });
    bar.style.backgroundImage = `linear-gradient(to right, ${colours.join()})`;
    return bar;
  }
}

/** What the ends of a ramp are, with their unit. */
export function endsOf(colour: ViewState['colour'], [low, high]: [number, number], points: number): [string, string] | undefined {
  if (colour === 'height') return [`${metres(low)}`, `${metres(high)} above the first camera`];
  if (colour === 'age') return ['came first', `came last, of ${count(points)} points`];
  return undefined;
}

function metres(value: number): string {
  const digits = Math.abs(value) < 10 ? 1 : 0;
  return `${value < 0 ? '−' : ''}${Math.abs(value).toFixed(digits)} m`;
}

/** No point of the map comes with how many keyframes see it. */
export function isUntold({ pointCount, observedPoints }: Observed): boolean {
  return pointCount > 0 && observedPoints === 0;
}

/** What the ramp does not say of; empty: nothing. */
export function untoldText(map: Observed): string {
  if (isUntold(map)) return 'The store does not tell how many keyframes see a point: points are in their robots’ colours';
  const untold = map.pointCount - map.observedPoints;
  return untold > 0 ? `in their robots’ colours: ${count(untold)} of which that is not told` : '';
}
