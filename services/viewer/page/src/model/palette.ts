// Colours that colour-blind people can tell apart (after Okabe and Ito), one set for each theme.
export type Theme = 'light' | 'dark';
export type ColourMode = 'robot' | 'island' | 'paper' | 'height' | 'age' | 'observations';

/** The ends of the ramp of how many keyframes see a point; it is logarithmic. */
export const FEW_OBSERVATIONS = 2;
export const MANY_OBSERVATIONS = 20;

const LIGHT = ['#0072b2', '#c94f00', '#00805c', '#a8347d', '#7a6500', '#2f8fb8', '#5b4bb0', '#5a5a5a'];
const DARK = ['#5cb8f0', '#ff9a4d', '#2fd6a0', '#f08bc8', '#f0e060', '#9ad7f5', '#b5a6ff', '#c8c8c8'];

// What robots beyond the eighth and the sixteenth are mixed with.
const SHADES: Record<Theme, string>[] = [{ light: '#000000', dark: '#303840' }, { light: '#ffffff', dark: '#ffffff' }];

export function categoryColour(theme: Theme, number: number): string {
  const colours = theme === 'light' ? LIGHT : DARK;
  const round = Math.floor(number / colours.length) % (SHADES.length + 1);
  const colour = colours[number % colours.length];
  return round === 0 ? colour : mixed(colour, SHADES[round - 1][theme], 0.45);
}

/** So much of the way from one colour to another, both as #rrggbb. */
export function mixed(a: string, b: string, part: number): string {
  const channel = (colour: string, i: number) => Number.parseInt(colour.slice(1 + 2 * i, 3 + 2 * i), 16);
  const mix = (i: number) => Math.round(channel(a, i) * (1 - part) + channel(b, i) * part);
  return `#${[0, 1, 2].map((i) => mix(i).toString(16).padStart(2, '0')).join('')}`;
}

/** Everything else that is drawn in the map. */
export interface SceneColours {
  background: string;
  ink: string;
  grid: string;
  own: string;
  others: string;
  accepted: string;
  refused: string;
  selected: string;
  truth: string;
  ramp: [string, string, string];
}

const SCENES: Record<Theme, SceneColours> = {
  light: {
    background: '#f7f8fa', ink: '#1a1d21', grid: '#d5d9df', own: '#0a8f2f', others: '#1f4fd8',
    accepted: '#0a7a2c', refused: '#8a8f98', selected: '#111111', truth: '#c62828', ramp: ['#1b3a7a', '#7c7b78', '#c29a00'],
  },
  dark: {
    background: '#0f1216', ink: '#e6e9ee', grid: '#262c35', own: '#3ddc64', others: '#6ea0ff',
    accepted: '#57e389', refused: '#8992a0', selected: '#ffffff', truth: '#ff6b6b', ramp: ['#4a7fe0', '#a09f9c', '#ffe04d'],
  },
};

export function sceneColours(theme: Theme): SceneColours {
  return SCENES[theme];
}
