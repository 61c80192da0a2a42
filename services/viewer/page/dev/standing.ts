// What pages cost a map store whose mission stands still: the processor time of the store and the viewer while
// 0, 1 and 20 pages' streams are open. Robots and fusion take none of it, so that little is seen, too.
//   --programs DIR --journal DIR: a store's --data-dir, which is copied [--mission NAME] [--runs N] [--seconds S]
import { cpSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import WebSocket from 'ws';
import { type Program, option, start } from './programs';

const VIEWERS = [0, 1, 20];
/** Of /proc's times, a second: fixed by Linux for all programs. */
const TICKS = 100;
/** A mission is followed for half a minute after its last page. */
const FORGOTTEN_MS = 35_000;
const seconds = Number(option('seconds', '20'));
const folder = mkdtempSync(join(tmpdir(), 'standing.'));
const places = { programs: option('programs'), logs: folder };
const pause = (ms: number) => new Promise((done) => setTimeout(done, ms));

function processorMs({ pid }: Program): number {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (1000 * (Number(fields[11]) + Number(fields[12]))) / TICKS;
}

async function measure(store: Program, viewer: Program, pages: number) {
  const begun = [processorMs(store), processorMs(viewer)];
  let bytes = 0;
  const sockets = Array.from({ length: pages }, () => {
    const socket = new WebSocket(`ws://${viewer.address}/stream/missions/${option('mission', 'demo')}?points=1`, ['corbslam']);
    return socket.on('message', (data: Buffer) => { bytes += data.length; });
  });
  await pause(1000 * seconds);
  const taken = [processorMs(store) - begun[0], processorMs(viewer) - begun[1]];
  for (const socket of sockets) socket.close();
  await pause(FORGOTTEN_MS);
  return { pages, seconds, store_ms: taken[0], viewer_ms: taken[1], bytes_a_page: pages ? Math.round(bytes / pages) : 0 };
}

cpSync(option('journal'), join(folder, 'store'), { recursive: true });
const running: Program[] = [];
const begin = async (name: string, args: string[]) => {
  const program = await start(name, ['--listen', '127.0.0.1:0', '--insecure', ...args], places);
  running.unshift(program);
  return program;
};
try {
  const worker = await begin('fusion_worker', []);
  const store = await begin('map_store', ['--worker', worker.address, '--data-dir', join(folder, 'store')]);
  const viewer = await begin('map_viewer', ['--store', store.address]);
  await pause(10_000);
  for (let run = 0; run < Number(option('runs', '3')); run++) {
    for (const pages of VIEWERS) console.log(JSON.stringify(await measure(store, viewer, pages)));
  }
} finally {
  for (const program of running) await program.stop();
  rmSync(folder, { recursive: true, force: true });
}
