import type { RobotSample, RobotSeries } from '../model/robot_series';
import { count } from '../model/texts';
import { h, setText } from './dom';

const WIDTH_PX = 252;
const HEIGHT_PX = 34;
/** Samples so far apart are not joined. */
const GAP_S = 20;

interface Kind {
  name: string;
  of: (sample: RobotSample) => number | undefined;
  say: (value: number) => string;
}

const KINDS: Kind[] = [
  { name: 'Frames tracked', of: (sample) => sample.trackedPerS, say: (value) => `${value.toFixed(1)} /s` },
  { name: 'Newest frame’s age', of: (sample) => sample.ageS, say: (value) => (value < 1 ? `${Math.round(1000 * value)} ms` : `${value.toFixed(1)} s`) },
  { name: 'Points of its map', of: (sample) => sample.points, say: (value) => count(Math.round(value)) },
];

/** How one robot did over the last minutes. */
export class RobotPlots {
  readonly root = h('div', { class: 'plots' });
  private readonly title = h('h3', {});
  private readonly rows = KINDS.map((kind) => {
    const canvas = h('canvas', { role: 'img' });
    const value = h('span', {});
    const root = h('div', { class: 'plot' }, h('div', { class: 'plot-head' }, h('span', {}, kind.name), value), canvas);
    return { kind, canvas, value, root };
  });
  private shown = '';

  constructor() {
    this.root.append(this.title, ...this.rows.map(({ root }) => root));
    this.root.hidden = true;
  }

  /** The chosen robot, or the first of which something was told. */
  update(series: RobotSeries, chosen: string, robots: readonly string[], colour: (robot: string) => string): void {
    const robot = chosen || (robots.find((one) => series.of(one).length > 1) ?? '');
    const samples = series.of(robot);
    this.root.hidden = samples.length < 2;
    if (this.root.hidden || this.root.offsetParent === null) return;
    const key = [robot, samples.at(-1)!.timeS, colour(robot)].join();
    if (key === this.shown) return;
    this.shown = key;
    const spanS = samples.at(-1)!.timeS - samples[0].timeS;
    setText(this.title, `${robot}, the last ${spanS < 90 ? `${Math.round(spanS)} s` : `${Math.round(spanS / 60)} min`}`);
    for (const { kind, canvas, value, root } of this.rows) {
      const known = samples.map(kind.of).filter((one) => one !== undefined);
      root.hidden = known.length < 2;
      if (root.hidden) continue;
      const words = `now ${kind.say(known.at(-1)!)}, most ${kind.say(Math.max(...known))}`;
      setText(value, words);
      canvas.setAttribute('aria-label', `${kind.name}: ${words}`);
      draw(canvas, samples, kind.of, colour(robot));
    }
  }
}

function draw(canvas: HTMLCanvasElement, samples: readonly RobotSample[], of: Kind['of'], colour: string): void {
  const ratio = Math.min(devicePixelRatio, 2);
  const width = canvas.clientWidth || WIDTH_PX;
  [canvas.width, canvas.height] = [width * ratio, HEIGHT_PX * ratio];
  const context = canvas.getContext('2d')!;
  context.scale(ratio, ratio);
  const [first, last] = [samples[0].timeS, samples.at(-1)!.timeS];
  const most = Math.max(...samples.map((sample) => of(sample) ?? 0)) || 1;
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.beginPath();
  let beforeS: number | undefined;
  for (const sample of samples) {
    const value = of(sample);
    if (value === undefined) continue;
    const x = ((sample.timeS - first) / Math.max(last - first, 1e-6)) * width;
    const y = HEIGHT_PX - 2 - (value / most) * (HEIGHT_PX - 4);
    if (beforeS === undefined || sample.timeS - beforeS > GAP_S) context.moveTo(x, y);
    else context.lineTo(x, y);
    beforeS = sample.timeS;
  }
  context.stroke();
}
