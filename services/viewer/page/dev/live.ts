// Walks through the page before a real map store, worker, viewer and robots: what comes, merges, goes
// and comes back must be seen. Pictures are kept. Run by tests/viewer/live_page_test.sh.
//   --programs DIR --source SOURCE --pictures DIR
import { type ChildProcess, spawn } from 'node:child_process';
import { createWriteStream, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { type Page, chromium } from 'playwright-core';

const BROWSER = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const PATIENCE_MS = 240_000;

function option(name: string): string {
  const at = process.argv.indexOf(`--${name}`);
  if (at < 0) throw new Error(`--${name} is missing`);
  return process.argv[at + 1];
}
const programs = option('programs');
const pictures = option('pictures');
const folder = mkdtempSync(join(tmpdir(), 'live_page.'));
mkdirSync(pictures, { recursive: true });

/** Starts a program; `address` is what it says to listen on. */
class Program {
  address = '';
  private readonly child: ChildProcess;
  private readonly ended: Promise<void>;

  constructor(readonly name: string, args: string[]) {
    this.child = spawn(join(programs, name), args, { stdio: ['ignore', 'pipe', 'pipe'] });
    this.child.stderr!.pipe(createWriteStream(join(pictures, `${name}.log`), { flags: 'a' }));
    this.ended = new Promise((done) => this.child.once('exit', () => done()));
  }

  async listening(): Promise<string> {
    for await (const chunk of this.child.stdout!) {
      const found = /listening on (\S+)/.exec(String(chunk));
      if (!found) continue;
      this.child.stdout!.resume();
      return (this.address = found[1]);
    }
    throw new Error(`${this.name} ended before it listened; ${pictures}/${this.name}.log says why`);
  }

  end(): Promise<void> { return this.ended; }

  async stop(): Promise<void> {
    this.child.kill('SIGTERM');
    await this.ended;
  }
}

async function start(name: string, args: string[]): Promise<Program> {
  const program = new Program(name, args);
  await program.listening();
  return program;
}

function startStore(worker: string, listen = '127.0.0.1:0'): Promise<Program> {
  return start('map_store', ['--listen', listen, '--insecure', '--worker', worker, '--data-dir', join(folder, 'store')]);
}

function startViewer(store: string, listen = '127.0.0.1:0'): Promise<Program> {
  return start('map_viewer', ['--listen', listen, '--insecure', '--store', store]);
}

function play(store: string, mission: string): Program {
  return new Program('corbslam', ['run', '--server', store, '--insecure', '--mission', mission, '--pace', 'sensor',
    '--source', option('source'), '--out', join(folder, mission)]);
}

const errors: string[] = [];
let isAway = false;

async function open(browser: Awaited<ReturnType<typeof chromium.launch>>, url: string): Promise<Page> {
  const context = await browser.newContext({ viewport: { width: 1600, height: 900 } });
  const page = await context.newPage();
  // While a server is away on purpose the browser itself complains of the connection.
  page.on('console', (message) => message.type() === 'error' && !isAway && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('dialog', (dialog) => { errors.push(`a dialog: ${dialog.message()}`); void dialog.dismiss(); });
  await page.goto(url);
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
  await page.locator('canvas.keypoints').waitFor({ timeout: 20_000 });
  check(true, 'a keyframe shows its keypoints');
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
  await page.getByRole('button', { name: 'Live' }).click();
  await until(page, 'window.corbslam.shownRevision === window.corbslam.revision');
  check(Number(before) <= Number(await page.evaluate('window.corbslam.keyframes')), 'the past had fewer keyframes than now');
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

async function walk(browser: Awaited<ReturnType<typeof chromium.launch>>): Promise<void> {
  const worker = await start('fusion_worker', ['--listen', '127.0.0.1:0', '--insecure']);
  let store = await startStore(worker.address);
  let viewer = await startViewer(store.address);
  try {
    const home = `http://${viewer.address}/`;
    const page = await open(browser, `${home}#mission=lab`);
    await watchTheMerge(page, store.address);
    await lookCloser(page);
    await scrub(page);
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
