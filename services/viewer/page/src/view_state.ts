import type { ColourMode, Theme } from './model/palette';

export type Layer = 'global' | 'local' | 'both';

/** What the user chose to see; the address carries it, so that a link opens the same. */
export interface ViewState {
  mission: string;
  colour: ColourMode;
  layer: Layer;
  theme: Theme | 'auto';
  points: boolean;
  keyframes: boolean;
  paths: boolean;
  frames: boolean;
  overlaps: boolean;
  refused: boolean;
  top: boolean;
  /** The robot whose eyes count: highlighted, and "own" in the paper's colours. */
  robot: string;
  follow: boolean;
  hidden: Set<string>;
  /** Pixels that a point has at least. */
  size: number;
  /** Where the global layer's camera looks and stands, where somebody chose it: six numbers. */
  camera: number[];
  /** What was clicked: the end of a keyframe's or an overlap's name; empty: nothing. */
  chosen: string;
  /** A moment of the past, as History.moment says it; empty: live. */
  at: string;
}

export const SIZES = [1, 1.5, 2.5, 4, 6];
export const USUAL_SIZE = 1.5;
const CHOSEN = /^(?:localMaps\/[0-9a-f]{16}\/keyframes\/\d{1,10}|overlaps\/\d{1,18})$/;
const MOMENT = /^\d{1,18}\.\d{1,15}$/;

const SHOW = { p: 'points', k: 'keyframes', t: 'paths', f: 'frames', o: 'overlaps', r: 'refused' } as const;
const COLOURS: ColourMode[] = ['robot', 'island', 'paper', 'height', 'age', 'observations'];
const LAYERS: Layer[] = ['global', 'local', 'both'];

/** Reads the address's fragment; what is unknown there is passed over. */
export function parseState(fragment: string): ViewState {
  const values = new URLSearchParams(fragment.replace(/^#/, ''));
  const show = values.get('show') ?? 'pkto';
  const oneOf = <T extends string>(name: string, all: T[]) => all.find((value) => value === values.get(name)) ?? all[0];
  const flags = Object.fromEntries(Object.entries(SHOW).map(([letter, name]) => [name, show.includes(letter)]));
  return {
    ...(flags as Record<(typeof SHOW)[keyof typeof SHOW], boolean>),
    mission: values.get('mission') ?? '',
    colour: oneOf('colour', COLOURS),
    layer: oneOf('layer', LAYERS),
    theme: oneOf<'auto' | Theme>('theme', ['auto', 'light', 'dark']),
    top: values.get('top') === '1',
    robot: values.get('robot') ?? '',
    follow: values.get('follow') === '1',
    hidden: new Set((values.get('hidden') ?? '').split(',').filter(Boolean)),
    size: SIZES.find((size) => size === Number(values.get('size'))) ?? USUAL_SIZE,
    camera: parseCamera(values.get('camera')),
    chosen: CHOSEN.exec(values.get('chosen') ?? '')?.[0] ?? '',
    at: MOMENT.exec(values.get('at') ?? '')?.[0] ?? '',
  };
}

export function formatState(state: ViewState): string {
  const values = new URLSearchParams({ mission: state.mission });
  const show = Object.entries(SHOW).filter(([, name]) => state[name]).map(([letter]) => letter).join('');
  if (show !== 'pkto') values.set('show', show);
  if (state.colour !== 'robot') values.set('colour', state.colour);
  if (state.layer !== 'global') values.set('layer', state.layer);
  if (state.theme !== 'auto') values.set('theme', state.theme);
  if (state.top) values.set('top', '1');
  if (state.robot) values.set('robot', state.robot);
  if (state.follow) values.set('follow', '1');
  if (state.hidden.size > 0) values.set('hidden', [...state.hidden].join(','));
  if (state.size !== USUAL_SIZE) values.set('size', String(state.size));
  if (state.camera.length > 0) values.set('camera', state.camera.map((value) => Number(value.toFixed(2))).join());
  if (state.chosen) values.set('chosen', state.chosen);
  if (state.at) values.set('at', state.at);
  // What needs no escape in a fragment stays readable.
  return `#${values}`.replaceAll('%2C', ',').replaceAll('%2F', '/');
}

/** Shows a state in the address, so that a link opens the same; inside a report the page has no address. */
export function keepInAddress(state: ViewState): void {
  if (location.protocol !== 'about:') history.replaceState(null, '', formatState(state));
}

/** Six numbers, of which the last three are another place than the first three; else none. */
function parseCamera(text: string | null): number[] {
  const numbers = (text ?? '').split(',').map(Number);
  const isPlace = numbers.length === 6 && numbers.every((value) => Number.isFinite(value) && Math.abs(value) < 1e7);
  if (!isPlace) return [];
  return [0, 1, 2].some((k) => numbers[k] !== numbers[k + 3]) ? numbers : [];
}
