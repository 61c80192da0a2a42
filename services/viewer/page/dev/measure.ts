// Measures the page with 10,000 keyframes and 1,000,000 points in Chromium: how soon they are seen, and what
// turning them costs. The renderer says whether a graphics processor was there. Prints one JSON object a run.
//   --runs=3 --width=1920 --height=1080 --seconds=10: of turning
import { spawn } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { type Browser, type Page, chromium } from 'playwright-core';

const PORT = '8092';
const FLAGS = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const PATIENCE_MS = 240_000;

function option(name: string, otherwise: number): number {
  const given = process.argv.find((argument) => argument.startsWith(`--${name}=`));
  return given ? Number(given.split('=')[1]) : otherwise;
}

interface Frame { atMs: number; drawCalls: number; drawnPoints: number; scriptMs: number }

async function until(page: Page, expression: string): Promise<void> {
  for (const end = Date.now() + PATIENCE_MS; !(await page.evaluate(expression)); ) {
    if (Date.now() > end) throw new Error(`never came true: ${expression}`);
    await page.waitForTimeout(100);
  }
}

function ask<T>(page: Page, expression: string): Promise<T> {
  return page.evaluate(`window.corbslam.${expression}`) as Promise<T>;
}

/** Drags over the map for some seconds. */
async function turn(page: Page, x: number, y: number): Promise<Frame[]> {
  await page.mouse.move(x, y);
  await page.mouse.down();
  await ask(page, 'watchFrames()');
  const end = Date.now() + 1000 * option('seconds', 10);
  for (let i = 0; Date.now() < end; i++) {
    await page.mouse.move(x + 3 * (i % 60), y + (i % 7));
    await page.waitForTimeout(15);
  }
  const frames = await ask<Frame[]>(page, 'watchFrames()');
  await page.mouse.up();
  return frames;
}

function quantile(values: number[], part: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] ?? NaN;
}

function describe(frames: Frame[]) {
  const seconds = (frames.at(-1)!.atMs - frames[0].atMs) / 1000;
  const script = frames.map(({ scriptMs }) => scriptMs);
  const round = (value: number) => Math.round(10 * value) / 10;
  return {
    frames: frames.length, framesASecond: round((frames.length - 1) / seconds),
    scriptMs: { p50: round(quantile(script, 0.5)), p99: round(quantile(script, 0.99)) },
    drawCalls: Math.max(...frames.map(({ drawCalls }) => drawCalls)),
    drawnPoints: { p50: quantile(frames.map(({ drawnPoints }) => drawnPoints), 0.5), last: frames.at(-1)!.drawnPoints },
  };
}

const RENDERER = `(() => { const gl = document.createElement('canvas').getContext('webgl2');
  return gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL); })()`;

async function measure(browser: Browser, run: number) {
  const [width, height] = [option('width', 1920), option('height', 1080)];
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: 'dark' });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  await page.goto(`http://127.0.0.1:${PORT}/#mission=lab`);
  await until(page, 'window.corbslam?.seenMs.whole !== undefined');
  const seenMs = await ask<{ first: number; whole: number }>(page, 'seenMs');
  await page.waitForTimeout(3000);
  const figures = await ask<Record<string, number>>(page, 'figures()');
  await page.screenshot({ path: `out/look/big_${run}.png`, timeout: PATIENCE_MS });
  const turning = describe(await turn(page, width / 2, height / 2));
  const renderer = await page.evaluate(RENDERER);
  await context.close();
  return { run, renderer, width, height, firstSeenMs: Math.round(seenMs.first), allSeenMs: Math.round(seenMs.whole), still: figures, turning };
}

mkdirSync('out/look', { recursive: true });
const server = spawn(process.execPath, ['out/fake_server.mjs', `--port=${PORT}`, '--big', '--still', '--merge=1e9'], { stdio: ['ignore', 'pipe', 'inherit'] });
await new Promise((done) => server.stdout!.once('data', done));
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: FLAGS });
try {
  for (let run = 1; run <= option('runs', 3); run++) console.log(JSON.stringify(await measure(browser, run)));
} finally {
  await browser.close();
  server.kill();
}
