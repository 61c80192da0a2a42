import type { HistoryStep } from '../model/history';
import { count, many } from '../model/texts';
import { h } from './dom';

/** What the timeline asks of the page. */
export interface TimelineActions {
  seek(step: number): void;
  live(): void;
}

/** What happened at a step. */
export interface TimelineMark {
  step: number;
  kind: string;
  words: string[];
}

const MOST_WORDS = 6;
const SPEEDS: [string, string][] = [['1', '1×'], ['2', '2×'], ['5', '5×'], ['20', '20×']];
const STEP_MS = 500;

/** The slider over the moments of the past, with play and pause. */
export class Timeline {
  readonly root: HTMLElement;
  private readonly slider = h('input', { type: 'range', min: '0', step: '1', 'aria-label': 'Moment' });
  private readonly marks = h('div', { class: 'marks', 'aria-label': 'What happened' });
  private readonly words = h('output', { class: 'timeline-words' });
  private readonly playButton = h('button', { type: 'button', click: () => this.togglePlay() }, '▶ Play');
  private readonly speed = h('select', { 'aria-label': 'Speed' }, ...SPEEDS.map(([value, text]) => h('option', { value }, text)));
  /** What is to be known of all moments. */
  note = '';
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly actions: TimelineActions) {
    this.root = h('section', { class: 'timeline', 'aria-label': 'History' }, this.playButton, this.speed,
      h('div', { class: 'track' }, this.slider, this.marks), this.words, h('button', { type: 'button', class: 'live', click: () => actions.live() }, 'Live'));
    this.root.hidden = true;
    this.slider.addEventListener('input', () => actions.seek(Number(this.slider.value)));
  }

  get isOpen(): boolean {
    return !this.root.hidden;
  }

  open(): void {
    this.root.hidden = false;
    if (!this.slider.disabled && this.slider.max !== '') return;
    this.wait('Fetching the history …');
  }

  close(): void {
    this.pause();
    this.root.hidden = true;
    this.slider.max = '';
    this.marks.replaceChildren();
  }

  fail(reason: string): void {
    this.wait(`The past can’t be shown: ${reason}`);
  }

  private wait(words: string): void {
    this.words.textContent = words;
    for (const element of [this.slider, this.playButton, this.speed]) element.disabled = true;
  }

  /** Says something beside the moment, until another one is shown. */
  say(words: string): void {
    this.words.textContent = words;
  }

  /** Shows what happened as marks that lead to their steps, of so many. */
  mark(marks: readonly TimelineMark[], steps: number, go: (step: number) => void): void {
    this.marks.replaceChildren(...marks.map(({ step, kind, words }) => {
      const more = words.length > MOST_WORDS ? [`and ${words.length - MOST_WORDS} more`] : [];
      const title = [...words.slice(0, MOST_WORDS), ...more].join('\n');
      const button = h('button', { type: 'button', class: `mark ${kind}`, title, 'aria-label': title, click: () => go(step) });
      button.style.setProperty('--at', String(steps > 1 ? step / (steps - 1) : 0));
      return button;
    }));
  }

  /** `clock`: when that was, as far as events say it. */
  show(steps: HistoryStep[], position: number, clock = ''): void {
    this.slider.max = String(Math.max(0, steps.length - 1));
    this.slider.value = String(position);
    const step = steps[position];
    if (!step) return;
    for (const element of [this.slider, this.playButton, this.speed]) element.disabled = false;
    const text = [stepText(step, steps[position - 1], position, steps.length), clock, this.note].filter(Boolean).join(' · ');
    this.words.textContent = text;
    this.slider.setAttribute('aria-valuetext', text);
  }

  togglePlay(): void {
    if (this.timer !== undefined) return this.pause();
    if (this.slider.value === this.slider.max) this.actions.seek(0);
    this.playButton.textContent = '❚❚ Pause';
    this.schedule();
  }

  private schedule(): void {
    this.timer = setTimeout(() => {
      if (Number(this.slider.value) >= Number(this.slider.max)) return this.pause();
      this.actions.seek(Number(this.slider.value) + 1);
      this.schedule();
    }, STEP_MS / Number(this.speed.value));
  }

  private pause(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.playButton.textContent = '▶ Play';
  }
}

function stepText({ revision, summary, time }: HistoryStep, before: HistoryStep | undefined, position: number, all: number): string {
  const parts = [`Revision ${count(revision)}`, `step ${position + 1} of ${all}`];
  if (position === 0) parts.push('the oldest that the journal has');
  if (summary) {
    parts.push(`${many(summary.islands, 'island')}${change(summary.islands, before?.summary?.islands)}`);
    parts.push(`${many(summary.keyframes, 'keyframe')}${change(summary.keyframes, before?.summary?.keyframes)}`);
  }
  if (time) parts.push(time);
  return parts.join(' · ');
}

function change(now: number, before: number | undefined): string {
  if (before === undefined || before === now) return '';
  return now > before ? ` (+${now - before})` : ` (−${before - now})`;
}
