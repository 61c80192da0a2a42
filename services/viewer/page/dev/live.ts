// Walks through the page before a real map store, worker, viewer and robots: what comes, merges, goes
// and comes back must be seen. Pictures are kept. Run by tests/viewer/live_page_test.sh.
//   --programs DIR --source SOURCE --pictures DIR [--page DIR]
import { mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { type Browser, type BrowserContextOptions, type Page, chromium } from 'playwright-core';
import { checkNames, makeToken, pinchAndTurn, playPast, tapUntilShown } from './hands';
import { Program, option, start } from './programs';

const BROWSER = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const PATIENCE_MS = 240_000;
/** Without: the page that the viewer was built with. */
const PAGE = option('page', '') ? ['--page', option('page')] : [];

const pictures = option('pictures');
const places = { programs: option('programs'), logs: pictures };
const folder = mkdtempSync(join(tmpdir(), 'live_page.'));
mkdirSync(pictures, { recursive: true });

function startStore(worker: string, listen = '127.0.0.1:0'): Promise<Program> {
  return start('map_store', ['--listen', listen, '--insecure', '--worker', worker, '--data-dir', join(folder, 'store')], places);
}

function startViewer(store: string, listen = '127.0.0.1:0'): Promise<Program> {
  return start('map_viewer', ['--listen', listen, '--insecure', '--store', store, ...PAGE], places);
}

function play(store: string, mission: string): Program {
  return new Program('corbslam', ['run', '--server', store, '--insecure', '--mission', mission, '--pace', 'sensor',
    '--source', option('source'), '--out', join(folder, mission)], places);
}

const errors: string[] = [];
let isAway = false;

async function open(browser: Browser, url: string, options: BrowserContextOptions = {}): Promise<Page> {
  const context = await browser.newContext({ viewport: { width: 1600, height: 900 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE_MS);
  // While a server is away on purpose the browser itself complains of the connection.
  page.on('console', (message) => message.type() === 'error' && !isAway && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('dialog', (dialog) => { errors.push(`a dialog: ${dialog.message()}`); void dialog.dismiss(); });
  await page.goto(url, { timeout: PATIENCE_MS });
  return page;
}

async function until(page: Page, expression: string): Promise<void> {
  for (const end = Date.now() + PATIENCE_MS; !(await page.evaluate(expression)); ) {
    if (Date.now() > end) {
      await page.screenshot({ path: join(pictures, 'failed.png') });
      throw new Error(`never came true: ${expression}`);
    }
    await page.waitForTimeout(50);
  }
}

function check(isRight: boolean, what: string): void {
  if (!isRight) throw new Error(what);
  console.log(`ok: ${what}`);
}

async function shot(page: Page, name: string): Promise<void> {
  await page.screenshot({ path: join(pictures, `${name}.png`) });
}

async function watchTheMerge(page: Page, store: string): Promise<void> {
  const robots = play(store, 'lab');
  await until(page, 'window.corbslam?.robots.length === 2 && window.corbslam.islands === 2 && window.corbslam.points > 0');
  check(true, 'two robots stand apart, each in an island of its own');
  await page.keyboard.press('f');
  await shot(page, '01_apart');
  await until(page, 'window.corbslam.islands === 1 && window.corbslam.revision > 0');
  check(true, 'two islands became one while the page looked');
  await shot(page, '02_merging');
  await until(page, '!window.corbslam.moving');
  await robots.end();
  await until(page, 'window.corbslam.keyframes > 5 && window.corbslam.points > 500');
  await page.keyboard.press('f');
  await page.waitForTimeout(1000);
  await shot(page, '03_merged');
  const words = await page.locator('.panel').allTextContents();
  check(words.join(' ').includes('became one'), 'the events say that the maps became one');
}

async function lookCloser(page: Page): Promise<void> {
  await page.keyboard.press('r');
  await until(page, 'window.corbslam.overlaps > 0');
  await page.locator('.overlap').first().click();
  check((await page.getByText('Words in common').count()) > 0, 'a click on an overlap shows what was counted');
  await shot(page, '04_overlap');
  await page.keyboard.press('Escape');
  await page.evaluate('window.corbslam.select(window.corbslam.keyframeNames()[0])');
  await page.locator('figure.seen-figure input[type=checkbox]').waitFor({ timeout: 20_000 });
  check(true, "a keyframe shows its camera's picture, with its keypoints");
  await shot(page, '05_keyframe');
  await page.keyboard.press('Escape');
}

async function scrub(page: Page): Promise<void> {
  await page.getByRole('button', { name: 'History' }).click();
  await until(page, 'window.corbslam.historyRevisions > 1');
  await page.locator('.timeline input').fill('0');
  await until(page, 'window.corbslam.shownRevision < window.corbslam.revision');
  const before = await page.evaluate('window.corbslam.keyframes');
  await shot(page, '06_past');
  const moments = await playPast(page);
  check(moments.length > 1 && moments.every((at, i) => i === 0 || at > moments[i - 1]), `the past plays from its begin to its end: ${moments.length} moments`);
  await page.getByRole('button', { name: 'Live' }).click();
  await until(page, 'window.corbslam.shownRevision === window.corbslam.revision');
  check(Number(before) <= Number(await page.evaluate('window.corbslam.keyframes')), 'the past had fewer keyframes than now');
}

/** What a person does on a phone: two fingers, one finger, the panels' tabs. */
async function touch(browser: Browser, url: string): Promise<void> {
  const phone = await open(browser, url, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await until(phone, 'window.corbslam?.keyframes > 1 && !window.corbslam.moving');
  const { before, pinched, turned } = await pinchAndTurn(phone);
  check(pinched.distance < 0.8 * before.distance, 'two fingers that part go nearer');
  check(Math.abs(turned.azimuth - pinched.azimuth) > 5, 'one finger turns the map');
  await tapUntilShown(phone.getByRole('button', { name: 'Events' }), phone.locator('#events'));
  check(true, 'a tap on a tab shows its panel');
  await shot(phone, '09_phone');
  await phone.close();
}

/** A viewer that wants tokens: the page asks, refuses what is bad, and takes what is good. */
async function showToken(browser: Browser, store: string): Promise<void> {
  const { publicKey, token } = makeToken(folder, places, 'lab');
  const viewer = await start('map_viewer', ['--listen', '127.0.0.1:0', '--insecure', '--store', store,
    '--token-key', publicKey, ...PAGE], places);
  isAway = true;  // The browser itself complains of answers with 401.
  const page = await open(browser, `http://${viewer.address}/#mission=lab`);
  const prompt = page.getByLabel('Token');
  await prompt.waitFor();
  check(await page.getByText('refused').count() === 0, 'who gave no token is told of none that was refused');
  await shot(page, '10_token');
  await prompt.fill('corbslam1.bad.token');
  await prompt.press('Enter');
  await page.getByText('The token was refused.').waitFor();
  check(true, 'a bad token is refused, and asked for again');
  await prompt.fill(token);
  await page.getByRole('button', { name: 'Go on' }).click();
  await until(page, 'window.corbslam?.keyframes > 1');
  check(!page.url().includes(token), 'a token opens its mission, and is not in the address');
  const linked = await open(browser, `http://${viewer.address}/#mission=field&token=${token}`);
  await linked.getByText('This token does not open this mission.').waitFor();
  check(!linked.url().includes(token), 'a token of another mission is refused, and goes out of the address');
  for (const one of [page, linked]) await one.close();
  isAway = false;
  await viewer.stop();
}

async function comeBack(page: Page, restart: () => Promise<void>, what: string): Promise<void> {
  isAway = true;
  const keyframes = await page.evaluate('window.corbslam.keyframes');
  await restart();
  await until(page, `window.corbslam.connected && document.querySelector('.banner').hidden && window.corbslam.keyframes === ${keyframes}`);
  await page.waitForTimeout(1500);
  isAway = false;
  check(true, what);
}

async function walk(browser: Browser): Promise<void> {
  const worker = await start('fusion_worker', ['--listen', '127.0.0.1:0', '--insecure'], places);
  let store = await startStore(worker.address);
  let viewer = await startViewer(store.address);
  try {
    const home = `http://${viewer.address}/`;
    const page = await open(browser, `${home}#mission=lab`);
    await watchTheMerge(page, store.address);
    await lookCloser(page);
    await scrub(page);
    check((await checkNames(page)).length === 0, 'every control has a name that screen readers say');
    await touch(browser, `${home}#mission=lab`);
    const second = play(store.address, 'field');
    const other = await open(browser, `${home}#mission=field`);
    await until(other, 'window.corbslam?.keyframes > 1');
    check(Number(await page.evaluate('window.corbslam.keyframes')) > 1, 'two missions are seen at once');
    await second.end();
    const hostile = await open(browser, `${home}#mission=${encodeURIComponent('<img src=x onerror=alert(1)>')}`);
    await hostile.waitForTimeout(1500);
    check((await hostile.locator('img').count()) === 0, 'a hostile name is text');
    await shot(hostile, '07_hostile');
    await hostile.close();
    await showToken(browser, store.address);
    const list = await open(browser, home);
    await list.getByText('field').first().waitFor({ timeout: 20_000 });
    check(true, 'the start page lists the missions');
    await comeBack(page, async () => {
      await store.stop();
      await until(page, '!document.querySelector(".banner").hidden');
      await shot(page, '08_store_away');
      store = await startStore(worker.address, store.address);
    }, 'the map comes back with its store');
    await comeBack(page, async () => {
      await viewer.stop();
      viewer = await startViewer(store.address, viewer.address);
    }, 'the page comes back with its viewer');
  } finally {
    isAway = true;
    for (const program of [viewer, store, worker]) await program.stop();
  }
}

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: BROWSER });
try {
  await walk(browser);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
check(errors.length === 0, `no errors in the console${errors.map((error) => `\n  ${error}`).join('')}`);
process.exit(0);
