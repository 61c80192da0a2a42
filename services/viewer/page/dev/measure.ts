// Measures the page with 10,000 keyframes and 1,000,000 points in Chromium: how soon they are seen, what turning
// them costs and which part of it, what it costs to stand idle, and what changes and a merge cost. The renderer says
// whether a graphics processor was there. Prints one JSON object a run.
//   --runs=3 --width=1920 --height=1080 --seconds=10: of turning; --points=100: of each keyframe
//   --parts: turns without each part once more; --merge: two islands merge at the end of the last run
import { spawn } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { type Browser, type Page, chromium } from 'playwright-core';
import { processorMs } from './processor_time';
import { type Watched, takeWatched, watchPage } from './watch_page';

const PORT = '8092';
const FLAGS = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const PATIENCE_MS = 900_000;
const SITE = `http://127.0.0.1:${PORT}`;
/** The address's letters for what is shown: points, keyframes, paths. */
const PARTS = { points: 'kto', keyframes: 'pto', paths: 'pko', all: 'o' };
const CHANGES_A_SECOND = 10;
const CHANGED_POINTS = 1000;

function option(name: string, otherwise: number): number {
  const given = process.argv.find((argument) => argument.startsWith(`--${name}=`));
  return given ? Number(given.split('=')[1]) : otherwise;
}

interface Frame { atMs: number; drawCalls: number; drawnPoints: number; drawnKeyframes: number; scriptMs: number }

async function until(page: Page, expression: string): Promise<void> {
  for (const end = Date.now() + PATIENCE_MS; !(await page.evaluate(expression)); ) {
    if (Date.now() > end) throw new Error(`never came true: ${expression}`);
    await page.waitForTimeout(100);
  }
}

function ask<T>(page: Page, expression: string): Promise<T> {
  return page.evaluate(`window.corbslam.${expression}`) as Promise<T>;
}

/** What a span of time was: the page's pictures, its calls to WebGL, and the browser's processor time. */
interface Span { frames: Frame[]; watched: Watched; processor: Record<string, number> }

/** Watches the page while something goes on. */
async function during(page: Page, something: () => Promise<void>): Promise<Span> {
  await ask(page, 'watchFrames()');
  await takeWatched(page);
  const before = processorMs();
  await something();
  const [frames, watched, after] = [await ask<Frame[]>(page, 'watchFrames()'), await takeWatched(page), processorMs()];
  const processor = Object.fromEntries(Object.entries(after).map(([kind, ms]) => [kind, ms - (before[kind] ?? 0)]));
  return { frames, watched, processor };
}

/** Drags over the map for some seconds, and until it was drawn twice. */
async function turn(page: Page, x: number, y: number): Promise<Span> {
  await page.mouse.move(x, y);
  await page.mouse.down();
  const span = await during(page, async () => {
    const end = Date.now() + 1000 * option('seconds', 10);
    let drawn = 0;
    for (let i = 0; Date.now() < end || drawn < 2; i++) {
      await page.mouse.move(x + 3 * (i % 60), y + (i % 7));
      await page.waitForTimeout(15);
      if (Date.now() >= end) drawn = await page.evaluate('window.corbslam.watchedFrames');
    }
  });
  await page.mouse.up();
  return span;
}

function quantile(values: number[], part: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] ?? NaN;
}

const round = (value: number) => Math.round(10 * value) / 10;

function quantiles(values: number[]) {
  return { p50: round(quantile(values, 0.5)), p99: round(quantile(values, 0.99)), of: values.length };
}

function each<T, U>(record: Record<string, T>, of: (value: T) => U): Record<string, U> {
  return Object.fromEntries(Object.entries(record).map(([key, value]) => [key, of(value)]));
}

function describe({ frames, watched, processor }: Span) {
  const seconds = frames.length > 1 ? (frames.at(-1)!.atMs - frames[0].atMs) / 1000 : NaN;
  const middle = (of: (frame: Frame) => number) => quantile(frames.map(of), 0.5);
  const aPicture = (value: number) => Math.round(value / Math.max(1, frames.length));
  return {
    frames: frames.length, framesASecond: round((frames.length - 1) / seconds),
    scriptMs: quantiles(frames.map(({ scriptMs }) => scriptMs)), pageScriptMs: quantiles(watched.frameMs),
    processorMsAPicture: each(processor, aPicture),
    draws: each(watched.draws, ({ calls, vertices }) => ({ calls: aPicture(calls), vertices: aPicture(vertices) })),
    glCalls: aPicture(watched.glCalls), uploadedBytes: watched.uploadedBytes,
    drawnPoints: middle(({ drawnPoints }) => drawnPoints), drawnKeyframes: middle(({ drawnKeyframes }) => drawnKeyframes),
  };
}

/** Some thousand points move ten times a second. */
async function takeChanges(page: Page) {
  const rates = (rate: number) => fetch(`${SITE}/dev/changes?rate=${rate}&points=${CHANGED_POINTS}`);
  const { watched, ...span } = await during(page, async () => {
    await rates(CHANGES_A_SECOND);
    await page.waitForTimeout(1000 * option('seconds', 10));
    await rates(0);
    await page.waitForTimeout(500);
  });
  const changes = Math.max(1, watched.messageMs.length);
  return {
    messages: changes, messageMs: quantiles(watched.messageMs), bytesAMessage: Math.round(watched.uploadedBytes / changes),
    frames: span.frames.length, pageScriptMs: quantiles(watched.frameMs), processorMs: each(span.processor, Math.round),
  };
}

/** An island of a third of the map goes into another one. */
async function merge(page: Page) {
  const { watched, frames } = await during(page, async () => {
    await fetch(`${SITE}/dev/merge`);
    await until(page, 'window.corbslam.islands === 2 && !window.corbslam.moving');
  });
  return {
    messageMs: quantiles(watched.messageMs), uploadedBytes: watched.uploadedBytes,
    frames: frames.map(({ atMs, scriptMs, drawnPoints }) => [Math.round(atMs - frames[0].atMs), round(scriptMs), drawnPoints]),
  };
}

async function turnWithoutParts(page: Page, x: number, y: number) {
  const turns: Record<string, unknown> = {};
  for (const [part, shown] of Object.entries(PARTS)) {
    await page.evaluate(`location.hash = 'mission=lab&show=${shown}'`);
    await page.waitForTimeout(2000);
    const { processorMsAPicture, framesASecond } = describe(await turn(page, x, y));
    turns[part] = { processorMsAPicture, framesASecond };
  }
  await page.evaluate("location.hash = 'mission=lab'");
  await page.waitForTimeout(2000);
  return turns;
}

const RENDERER = `(() => { const gl = document.createElement('canvas').getContext('webgl2');
  return gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL); })()`;

async function measure(browser: Browser, run: number) {
  const [width, height] = [option('width', 1920), option('height', 1080)];
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: 'dark' });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  await watchPage(page);
  await page.goto(`${SITE}/#mission=lab`);
  await until(page, 'window.corbslam?.seenMs.whole !== undefined');
  const seenMs = await ask<{ first: number; whole: number }>(page, 'seenMs');
  await page.waitForTimeout(3000);
  const figures = await ask<Record<string, number>>(page, 'figures()');
  const still = describe(await during(page, () => ask(page, 'redraw()')));
  await page.screenshot({ path: `out/look/big_${run}.png`, timeout: PATIENCE_MS });
  const idle = await during(page, () => page.waitForTimeout(3000));
  const turning = describe(await turn(page, width / 2, height / 2));
  const without = process.argv.includes('--parts') ? await turnWithoutParts(page, width / 2, height / 2) : undefined;
  const changes = await takeChanges(page);
  const merging = process.argv.includes('--merge') && run === option('runs', 3) ? await merge(page) : undefined;
  const renderer = await page.evaluate(RENDERER);
  await context.close();
  return {
    run, renderer, width, height, firstSeenMs: Math.round(seenMs.first), allSeenMs: Math.round(seenMs.whole), figures, still,
    idle: { frames: idle.frames.length, glCalls: idle.watched.glCalls, processorMs: each(idle.processor, Math.round) },
    turning, without, changes, merging,
  };
}

mkdirSync('out/look', { recursive: true });
const server = spawn(process.execPath, ['out/fake_server.mjs', `--port=${PORT}`, '--big', `--points=${option('points', 100)}`, '--still', '--merge=1e9'], { stdio: ['ignore', 'pipe', 'inherit'] });
await new Promise((done) => server.stdout!.once('data', done));
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: FLAGS });
try {
  for (let run = 1; run <= option('runs', 3); run++) console.log(JSON.stringify(await measure(browser, run)));
} finally {
  await browser.close();
  server.kill();
}
