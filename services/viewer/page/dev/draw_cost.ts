// What parts of the picture cost a browser that draws without a graphics processor (SwiftShader): processor time of
// one picture of 1,002 keyframes and 5,010 points on 480x270, however long it waits. Prints a JSON object a round.
//   --rounds=3
import { build } from 'esbuild';
import { join } from 'node:path';
import { type Page, chromium } from 'playwright-core';
import { processorMs } from './processor_time';

const FLAGS = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const PARTS = { nothing: 'x', keyframes: 'k', paths: 't', points: 'p', all: 'pkt' };
const given = process.argv.find((argument) => argument.startsWith('--rounds='));

async function cost(page: Page, shown: string): Promise<number> {
  const before = processorMs()['gpu-process'];
  await page.evaluate(`window.draw('${shown}')`);
  return Math.round(processorMs()['gpu-process'] - before);
}

async function round(page: Page) {
  const costs: Record<string, Record<string, number>> = {};
  for (const [antialias, ratio] of [[true, 1], [false, 1], [true, 0.5], [false, 0.5]]) {
    await page.evaluate(`window.make(${antialias}, ${ratio})`);
    await page.evaluate("window.draw('pkt')");
    const ms: Record<string, number> = (costs[`${antialias ? 'antialiased' : 'plain'} ${ratio}`] = {});
    for (const [part, shown] of Object.entries(PARTS)) ms[part] = await cost(page, shown);
  }
  return costs;
}

const { outputFiles: [script] } = await build({
  entryPoints: [join('dev', 'draw_cost_page.ts')], bundle: true, write: false, format: 'iife', target: 'es2022', alias: { '@gen': './gen' },
});
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: FLAGS });
try {
  const page = await browser.newPage({ viewport: { width: 480, height: 270 } });
  page.setDefaultTimeout(900_000);
  await page.setContent('<body></body>');
  await page.addScriptTag({ content: script.text });
  for (let i = 0; i < Number(given?.split('=')[1] ?? 3); i++) console.log(JSON.stringify(await round(page)));
} finally {
  await browser.close();
}
