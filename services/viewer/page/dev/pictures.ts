// Makes the pictures of docs/viewer.md of a mission that was recorded: a merge before, in the middle and
// behind, the timeline, why an overlap was refused, a phone.
//   --parts merge,refused,overlap,timeline,phone --themes light,dark: these alone
//   --programs DIR --journal DIR: a store's --data-dir, which is copied --mission NAME --out DIR [--page DIR] [--truth FILE]
import { cpSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { type Browser, type Page, chromium } from 'playwright-core';
import { type Program, option, start } from './programs';

const FLAGS = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const PATIENCE_MS = 240_000;
const QUALITY = 0.7;
type Theme = 'light' | 'dark';
const MIDDLE_MS = 380;
const out = option('out');
const mission = option('mission', 'demo');
const folder = mkdtempSync(join(tmpdir(), 'pictures.'));
const places = { programs: option('programs'), logs: folder };

async function until(page: Page, expression: string): Promise<void> {
  for (const end = Date.now() + PATIENCE_MS; !(await page.evaluate(expression)); ) {
    if (Date.now() > end) throw new Error(`never came true: ${expression}`);
    await page.waitForTimeout(100);
  }
}

/** Keeps what is seen as WebP, which the browser itself makes of its PNG. */
async function keep(browser: Browser, page: Page, name: string): Promise<void> {
  const png = (await page.screenshot({ timeout: PATIENCE_MS })).toString('base64');
  const blank = await browser.newPage();
  const webp = await blank.evaluate(`(async () => {
    const image = new Image();
    image.src = 'data:image/png;base64,${png}';
    await image.decode();
    const canvas = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height });
    canvas.getContext('2d').drawImage(image, 0, 0);
    return canvas.toDataURL('image/webp', ${QUALITY}).split(',')[1];
  })()`);
  await blank.close();
  const bytes = Buffer.from(String(webp), 'base64');
  writeFileSync(join(out, `${name}.webp`), bytes);
  writeFileSync(join(folder, `${name}.png`), Buffer.from(png, 'base64'));
  console.log(name, bytes.length, 'bytes');
}

async function open(browser: Browser, home: string, width: number, height: number, theme: Theme, rest = ''): Promise<Page> {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: theme, hasTouch: width < 500 });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  page.on('pageerror', (error) => { throw error; });
  await page.goto(`${home}#mission=${mission}${rest}`, { timeout: PATIENCE_MS });
  await until(page, 'window.corbslam?.seenMs.whole !== undefined && !window.corbslam.moving');
  return page;
}

/** Opens the past, and goes to the step before the last two islands became one; returns that step. */
async function beforeTheMerge(page: Page): Promise<number> {
  await page.getByRole('button', { name: 'History' }).click();
  await until(page, 'window.corbslam.historyRevisions > 3');
  const slider = page.locator('.timeline input');
  for (let at = Number(await slider.getAttribute('max')); at >= 0; at--) {
    await slider.fill(String(at));
    if (Number(await page.evaluate('window.corbslam.islands')) > 1) return at;
  }
  throw new Error('no islands became one in this journal');
}

async function showMerge(browser: Browser, home: string, theme: Theme): Promise<void> {
  const page = await open(browser, home, 1920, 1080, theme);
  const slider = page.locator('.timeline input');
  const step = await beforeTheMerge(page);
  await page.waitForTimeout(1500);
  await page.keyboard.press('f');
  await page.waitForTimeout(1500);
  await keep(browser, page, `viewer_merge_before_${theme}`);
  // The move takes 0.8 s, less than a picture may: time stands still in its middle.
  await page.evaluate('window.standsAtMs = performance.now(); performance.now = () => window.standsAtMs');
  await slider.fill(String(step + 1));
  await until(page, 'window.corbslam.moving');
  await page.evaluate(`window.standsAtMs += ${MIDDLE_MS}`);
  await page.waitForTimeout(2000);
  await keep(browser, page, `viewer_merge_during_${theme}`);
  await page.evaluate('delete performance.now');
  await until(page, '!window.corbslam.moving');
  await page.getByRole('button', { name: 'Live' }).click();
  await page.keyboard.press('f');
  await page.waitForTimeout(2500);
  await keep(browser, page, `viewer_merge_after_${theme}`);
  await page.context().close();
}

/** Refused overlaps are drawn, and a click on the first says why. */
async function showRefusal(browser: Browser, home: string, theme: Theme): Promise<void> {
  const page = await open(browser, home, 1920, 1080, theme, '&show=pktor');
  await page.locator('.overlap.no').first().waitFor();
  await page.locator('.overlap.no').first().click();
  await page.waitForTimeout(2000);
  await keep(browser, page, `viewer_refused_${theme}`);
  await page.context().close();
}

/** The accepted overlap of two robots with the most pairs that agree, its pictures as large as the window. */
async function showOverlap(browser: Browser, home: string, theme: Theme): Promise<void> {
  const page = await open(browser, home, 1366, 768, theme, '&show=pkto');
  const rows = page.locator('.overlap.yes');
  await rows.first().waitFor();
  const pairs = await rows.evaluateAll((all) => all.map((row) => {
    const robots = (row.querySelector('.text')?.textContent ?? '').split('–').map((side) => side.trim().split(' ')[0]);
    return robots[0] === robots[1] ? 0 : parseInt((row.querySelector('small')?.textContent ?? '0').replace(/\u2009/g, ''), 10);
  }));
  await rows.nth(pairs.indexOf(Math.max(...pairs))).dispatchEvent('click');
  await page.locator('.seen-figure').waitFor();
  await page.locator('.enlarge').dispatchEvent('click');
  await page.waitForTimeout(1500);
  await keep(browser, page, `viewer_overlap_${theme}`);
  await page.context().close();
}

/** A moment with several islands, as it is scrubbed to. */
async function showTimeline(browser: Browser, home: string, theme: Theme): Promise<void> {
  const page = await open(browser, home, 1920, 1080, theme);
  const step = await beforeTheMerge(page);
  await page.locator('.timeline input').fill(String(Math.max(1, Math.floor(0.6 * step))));
  await until(page, '!window.corbslam.moving');
  await page.keyboard.press('f');
  await page.locator('.timeline input').blur();
  await page.waitForTimeout(2500);
  await keep(browser, page, `viewer_timeline_${theme}`);
  await page.context().close();
}

async function showPhone(browser: Browser, home: string, theme: Theme): Promise<void> {
  const page = await open(browser, home, 390, 844, theme);
  await page.getByRole('button', { name: 'Overlaps' }).last().tap();
  await page.waitForTimeout(1500);
  await keep(browser, page, `viewer_phone_${theme}`);
  await page.context().close();
}

mkdirSync(out, { recursive: true });
cpSync(option('journal'), join(folder, 'store'), { recursive: true });
const running: Program[] = [];
const begin = async (name: string, args: string[]) => {
  const program = await start(name, ['--listen', '127.0.0.1:0', '--insecure', ...args], places);
  running.unshift(program);
  return program.address;
};
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: FLAGS });
try {
  const worker = await begin('fusion_worker', []);
  const store = await begin('map_store', ['--worker', worker, '--data-dir', join(folder, 'store')]);
  const page = option('page', '') ? ['--page', option('page')] : [];
  const truth = option('truth', '') ? ['--truth', `${mission}=${option('truth')}`] : [];
  const home = `http://${await begin('map_viewer', ['--store', store, ...page, ...truth])}/`;
  const parts = { merge: showMerge, refused: showRefusal, overlap: showOverlap, timeline: showTimeline, phone: showPhone };
  for (const part of option('parts', Object.keys(parts).join()).split(',') as (keyof typeof parts)[]) {
    for (const theme of option('themes', 'light,dark').split(',') as Theme[]) await parts[part](browser, home, theme);
  }
} finally {
  await browser.close();
  for (const program of running) await program.stop();
  if (option('keep-png', '') === '') rmSync(folder, { recursive: true, force: true });
}
