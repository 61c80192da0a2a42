// Looks at the page in a browser: starts the simulated server, walks through what people do, and
// keeps pictures in out/look. Fails where the page wrote an error to the console.
//   --phone: only what a phone shows; --pictures: only keyframes' pictures and overlaps' matches
import { spawn } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { type Page, chromium } from 'playwright-core';

const PORT = '8091';
const BELOW = '/map';
const HOME = `http://localhost:${PORT}${BELOW}/`;
const SWIFT = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const errors: string[] = [];
let isAway = false;
mkdirSync('out/look', { recursive: true });
const server = spawn(process.execPath, ['out/fake_server.mjs', `--port=${PORT}`, `--merge=${process.argv.includes('--pictures') ? 6 : 30},1e9`, '--drives', '--steps=110', `--below=${BELOW}`], { stdio: ['ignore', 'pipe', 'inherit'] });
const isUp = new Promise((done) => server.stdout!.once('data', done));
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: SWIFT });

function hook<T>(page: Page, expression: string): Promise<T> {
  return page.evaluate(`window.corbslam.${expression}`) as Promise<T>;
}

/** Waits until an expression is true; playwright's own way would need a laxer content policy. */
async function until(page: Page, expression: string): Promise<void> {
  for (const end = Date.now() + 120_000; !(await page.evaluate(expression)); ) {
    if (Date.now() > end) throw new Error(`never came true: ${expression}`);
    await page.waitForTimeout(40);
  }
}

async function shot(page: Page, name: string): Promise<void> {
  await page.waitForTimeout(500);
  await page.screenshot({ path: `out/look/${name}.png`, timeout: 90_000 });
  console.log(name);
}

async function open(width: number, height: number, theme: 'light' | 'dark', fragment: string): Promise<Page> {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: theme, hasTouch: width < 500 });
  const page = await context.newPage();
  page.setDefaultTimeout(120_000);
  page.on('console', (message) => message.type() === 'error' && !isAway && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(HOME + fragment, { timeout: 90_000 });
  if (fragment) await until(page, 'window.corbslam?.keyframes > 1');
  return page;
}

async function lookAtMerge(): Promise<Page> {
  const page = await open(1920, 1080, 'light', '#mission=lab');
  await shot(page, '01_before_merge_light');
  await until(page, 'window.corbslam.revision > 0');
  await page.waitForTimeout(250);
  await page.screenshot({ path: 'out/look/02_merging.png' });
  await until(page, '!window.corbslam.moving');
  await page.keyboard.press('f');
  await shot(page, '03_after_merge_light');
  return page;
}

async function walk(): Promise<void> {
  const page = await lookAtMerge();
  await lookAtDetails(page);
  await lookAtPast(page);
  await lookInTheDark(page);
  await page.close();
}

async function lookAtDetails(page: Page): Promise<void> {
  await page.keyboard.press('r');
  await page.waitForTimeout(2500);
  await page.locator('.overlap.no').first().dispatchEvent('click');
  await shot(page, '04_refused_light');
  await page.keyboard.press('Escape');
  const names = await hook<string[]>(page, 'keyframeNames()');
  await page.evaluate((name) => (window as never as { corbslam: { select(n: string): void } }).corbslam.select(name), names[40]);
  await shot(page, '05_keyframe_light');
  await page.keyboard.press('Escape');
  await page.keyboard.press('r');
}

/** Keyframes' pictures and overlaps' matches, small and enlarged; `theme` is in the names. */
async function lookAtPictures(page: Page, theme: string): Promise<void> {
  const names = await hook<string[]>(page, 'keyframeNames()');
  const select = (name: string) => page.evaluate((chosen) =>
    (window as never as { corbslam: { select(n: string): void } }).corbslam.select(chosen), name);
  await select(names.find((name) => name.endsWith('/40'))!);
  await page.locator('.seen-figure').waitFor();
  await shot(page, `20_picture_${theme}`);
  await page.locator('.enlarge').dispatchEvent('click');
  await shot(page, `21_picture_enlarged_${theme}`);
  await page.keyboard.press('Escape');
  await select(names.find((name) => name.endsWith('/34'))!);
  await page.getByText('There is no picture of it').waitFor();
  await shot(page, `22_no_picture_${theme}`);
  await page.keyboard.press('Escape');
  for (const verdict of ['yes', 'no']) {
    await page.locator(`.overlap.${verdict}`).first().dispatchEvent('click');
    await page.locator('.seen-figure').waitFor();
    await shot(page, `23_overlap_${verdict}_${theme}`);
    await page.locator('.enlarge').dispatchEvent('click');
    await shot(page, `24_overlap_${verdict}_enlarged_${theme}`);
    await page.keyboard.press('Escape');
    await page.keyboard.press('Escape');
  }
}

async function walkPictures(): Promise<void> {
  for (const theme of ['light', 'dark'] as const) {
    const page = await open(1366, 768, theme, '#mission=lab&show=pktor');
    await until(page, 'window.corbslam.revision > 0');
    await lookAtPictures(page, theme);
    await page.close();
  }
  const phone = await open(390, 844, 'light', '#mission=lab&show=pktor');
  await phone.locator('.overlap.yes').first().dispatchEvent('click');
  await phone.locator('.seen-figure').waitFor();
  await shot(phone, '25_overlap_phone_light');
  await phone.locator('.enlarge').dispatchEvent('click');
  await shot(phone, '26_overlap_enlarged_phone_light');
}

async function lookAtPast(page: Page): Promise<void> {
  await page.keyboard.press('t');
  await page.selectOption('.toolbar select', 'paper');
  await page.keyboard.press('f');
  await shot(page, '06_paper_top_light');
  await page.keyboard.press('t');
  await page.getByRole('button', { name: 'History' }).click();
  await until(page, 'window.corbslam.historyRevisions > 3');
  await page.locator('.timeline input').fill('5');
  await shot(page, '07_history_light');
}

async function lookInTheDark(page: Page): Promise<void> {
  await page.keyboard.press('l');
  await page.getByRole('button', { name: 'Live' }).click();
  await page.selectOption('.toolbar select', 'height');
  await page.keyboard.press('f');
  await shot(page, '08_height_dark');
  await page.selectOption('.toolbar select', 'observations');
  await shot(page, '08_observations_dark');
  await page.keyboard.press('l');
  await shot(page, '08_observations_light');
  await page.keyboard.press('l');
  await page.selectOption('.toolbar select', 'robot');
  await page.keyboard.press('v');
  await page.keyboard.press('v');
  await page.waitForTimeout(2500);
  await page.keyboard.press('f');
  await shot(page, '09_side_by_side_dark');
  await page.keyboard.press('?');
  await shot(page, '10_help_dark');
}

/** What a person does at a laptop: measures, searches, opens a link again; then the viewer goes. */
async function walkAtLaptop(): Promise<void> {
  const page = await open(1366, 768, 'light', '#mission=lab&colour=height&size=2.5');
  await shot(page, '14_laptop_light');
  await page.getByRole('button', { name: 'Measure' }).click();
  await clickRobot(page, 'alpha');
  await clickRobot(page, 'beta');
  await page.keyboard.press('/');
  await page.keyboard.type('alpha #40');
  await page.waitForTimeout(300);
  await shot(page, '15_search_light');
  await page.keyboard.press('Enter');
  await page.locator('canvas.keypoints').waitFor();
  await page.mouse.move(700, 400);
  await page.mouse.wheel(0, -300);
  await page.waitForTimeout(900);
  await shot(page, '16_found_light');
  const link = page.url();
  const before = await page.evaluate('JSON.stringify(window.corbslam.camera)');
  const again = await open(1366, 768, 'dark', link.slice(link.indexOf('#')));
  await again.locator('canvas.keypoints').waitFor();
  const after = await again.evaluate('JSON.stringify(window.corbslam.camera)');
  await shot(again, '17_link_dark');
  console.log(`camera of the link: ${before} and ${after}`);
  server.kill();
  isAway = true;
  await page.locator('.banner:not([hidden])').waitFor();
  await shot(page, '18_away_light');
}

/** Clicks beside a robot's mark. */
async function clickRobot(page: Page, name: string, aside = 0): Promise<void> {
  const box = await page.locator('.label.robot', { hasText: name }).first().boundingBox();
  if (box) await page.mouse.click(box.x + aside, box.y + box.height / 2);
  await page.waitForTimeout(400);
}

async function walkOnPhone(): Promise<void> {
  const phone = await open(390, 844, 'dark', '#mission=lab');
  await shot(phone, '11_phone_dark');
  await phone.selectOption('.toolbar select', 'observations');
  await shot(phone, '11_phone_observations_dark');
  await phone.getByRole('button', { name: 'Events' }).click();
  await shot(phone, '12_phone_events_dark');
  await shot(await open(390, 844, 'light', ''), '13_start_phone_light');
}

try {
  await isUp;
  if (process.argv.includes('--pictures')) await walkPictures();
  else {
    if (!process.argv.includes('--phone')) {
      await walk();
      await walkPictures();
    }
    await walkOnPhone();
    await walkAtLaptop();
  }
} finally {
  await browser.close();
  server.kill();
}
if (errors.length > 0) throw new Error(`errors in the console:\n${errors.join('\n')}`);
