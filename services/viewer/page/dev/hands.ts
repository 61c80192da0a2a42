// What people do with the page by hand, and what a screen reader is told of it.
import { execFileSync } from 'node:child_process';
import { generateKeyPairSync } from 'node:crypto';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { CDPSession, Locator, Page } from 'playwright-core';
import type { Places } from './programs';

interface Camera { azimuth: number; polar: number; distance: number }
interface Finger { x: number; y: number }

const STEPS = 12;
const TAPS = 5;
/** The roles of what is acted with; each needs a name. */
const CONTROLS = ['button', 'checkbox', 'combobox', 'slider', 'link', 'textbox', 'application', 'image'];

function camera(page: Page): Promise<Camera> {
  return page.evaluate('window.corbslam.camera');
}

/** Fingers go from one place to another, as a touch screen tells it. */
async function drag(session: CDPSession, from: Finger[], to: Finger[]): Promise<void> {
  const at = (t: number) => from.map(({ x, y }, i) => ({ id: i, x: x + t * (to[i].x - x), y: y + t * (to[i].y - y) }));
  await session.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: at(0) });
  for (let i = 1; i <= STEPS; i++) {
    await session.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: at(i / STEPS) });
  }
  await session.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
}

/** Two fingers part in the middle of the map, then one goes across it. */
export async function pinchAndTurn(page: Page): Promise<{ before: Camera; pinched: Camera; turned: Camera }> {
  const session = await page.context().newCDPSession(page);
  const box = (await page.locator('.port').first().boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const before = await camera(page);
  await drag(session, [{ x: x - 20, y }, { x: x + 20, y }], [{ x: x - 110, y }, { x: x + 110, y }]);
  await page.waitForTimeout(300);
  const pinched = await camera(page);
  await drag(session, [{ x: x - 80, y }], [{ x: x + 80, y }]);
  await page.waitForTimeout(300);
  return { before, pinched, turned: await camera(page) };
}

/**
 * Taps on what shows a panel, again where the browser took the tap for a long press: a page drawn
 * without a graphics card may be asked for each touch later than a finger rests.
 */
export async function tapUntilShown(tab: Locator, panel: Locator): Promise<void> {
  for (let taps = 1; ; taps++) {
    await tab.tap();
    try {
      return await panel.waitFor({ state: 'visible', timeout: 5_000 });
    } catch (error) {
      if (taps === TAPS) throw error;
    }
  }
}

/** Plays an open history fast to its end; returns the moments that were seen, each once. */
export async function playPast(page: Page): Promise<number[]> {
  const slider = page.locator('.timeline input');
  const last = Number(await slider.getAttribute('max'));
  await page.getByLabel('Speed').selectOption('20');
  await slider.fill('0');
  await page.getByRole('button', { name: 'Play' }).click();
  const seen = [0];
  for (const end = Date.now() + 120_000; seen.at(-1)! < last && Date.now() < end; await page.waitForTimeout(10)) {
    const at = Number(await slider.inputValue());
    if (at !== seen.at(-1)) seen.push(at);
  }
  if (seen.at(-1) !== last) throw new Error(`playing stopped at moment ${seen.at(-1)} of ${last}`);
  await page.getByRole('button', { name: 'Play' }).waitFor();
  return seen;
}

/** Returns the roles of controls without a name, in the tree that screen readers are given. */
export async function checkNames(page: Page): Promise<string[]> {
  const session = await page.context().newCDPSession(page);
  const { nodes } = await session.send('Accessibility.getFullAXTree');
  const controls = nodes.filter(({ ignored, role }) => !ignored && CONTROLS.includes(String(role?.value)));
  if (controls.length < 20) throw new Error(`only ${controls.length} controls are in the accessibility tree`);
  return controls.filter(({ name }) => !String(name?.value ?? '').trim()).map(({ role }) => String(role?.value));
}

/** Makes a key and a token of it that may look at a mission. */
export function makeToken(folder: string, { programs }: Places, mission: string): { publicKey: string; token: string } {
  const keys = generateKeyPairSync('ed25519', {
    publicKeyEncoding: { type: 'spki', format: 'pem' }, privateKeyEncoding: { type: 'pkcs8', format: 'pem' },
  });
  const [privateKey, publicKey] = [join(folder, 'token.key'), join(folder, 'token.pub')];
  writeFileSync(privateKey, keys.privateKey, { mode: 0o600 });
  writeFileSync(publicKey, keys.publicKey);
  const token = execFileSync(join(programs, 'corbslam'), ['token', '--key', privateKey, '--mission', mission,
    '--role', 'viewer', '--agent', 'walker'], { encoding: 'utf8' });
  return { publicKey, token: token.trim() };
}
