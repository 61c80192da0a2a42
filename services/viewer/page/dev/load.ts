// What pages cost a map store: runs a mission several times, with 0, 1 and 20 pages' streams open, and
// prints a table and JSON.
//   --programs DIR --source SOURCE [--robots N] [--runs N] [--out DIR]
import { type ChildProcess, spawn } from 'node:child_process';
import { mkdirSync, readFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import WebSocket from 'ws';

const VIEWERS = [0, 1, 20];

function option(name: string, otherwise?: string): string {
  const at = process.argv.indexOf(`--${name}`);
  if (at >= 0) return process.argv[at + 1];
  if (otherwise === undefined) throw new Error(`--${name} is missing`);
  return otherwise;
}

interface Row { viewers: number; storeCpu_s: number; viewerCpu_s: number; bytes: number; seconds: number }

/** Opens streams and counts what comes. */
class Pages {
  bytes = 0;
  private readonly sockets: WebSocket[] = [];

  open(address: string, count: number): void {
    for (let i = 0; i < count; i++) {
      const socket = new WebSocket(`ws://${address}/stream/missions/demo?points=1`, ['corbslam']);
      socket.on('message', (data: Buffer) => { this.bytes += data.length; });
      socket.on('error', () => undefined);
      this.sockets.push(socket);
    }
  }
}

async function run(viewers: number, folder: string): Promise<Row> {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const begun = Date.now();
  const child: ChildProcess = spawn(join(option('programs'), 'corbslam'), ['run', '--view', '--pace', 'sensor',
    '--source', option('source'), '--robots', option('robots', '5'), '--out', folder], { stdio: ['ignore', 'pipe', 'ignore'] });
  const pages = new Pages();
  child.stdout!.on('data', (text: Buffer) => {
    const found = /Look: http:\/\/([^/]+)\//.exec(String(text));
    if (found) pages.open(found[1], viewers);
  });
  const code = await new Promise((done) => child.once('exit', done));
  if (code !== 0) throw new Error(`a run ended with ${code}; ${folder}/logs says why`);
  const { servers } = JSON.parse(readFileSync(join(folder, 'report.json'), 'utf8'));
  return { viewers, storeCpu_s: servers.map_store.cpu_s, viewerCpu_s: servers.map_viewer.cpu_s,
    bytes: viewers ? pages.bytes / viewers : 0, seconds: (Date.now() - begun) / 1000 };
}

function median(values: number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[sorted.length >> 1];
}

const rows: Row[] = [];
for (let i = 0; i < Number(option('runs', '3')); i++) {
  // Each begins once, so that what else the machine does falls on all alike.
  for (const viewers of [...VIEWERS.slice(i % 3), ...VIEWERS.slice(0, i % 3)]) rows.push(await run(viewers, join(option('out', 'out/load'), `${viewers}_${i}`)));
}
const of = (viewers: number, pick: (row: Row) => number) => rows.filter((row) => row.viewers === viewers).map(pick);
const none = median(of(0, (row) => row.storeCpu_s));
const table = VIEWERS.map((viewers) => ({
  viewers,
  store_cpu_s: of(viewers, (row) => row.storeCpu_s),
  store_ratio: median(of(viewers, (row) => row.storeCpu_s)) / none,
  store_ratio_least: Math.min(...of(viewers, (row) => row.storeCpu_s)) / Math.min(...of(0, (row) => row.storeCpu_s)),
  viewer_cpu_s: of(viewers, (row) => row.viewerCpu_s),
  seconds: of(viewers, (row) => Math.round(10 * row.seconds) / 10),
  bytes_a_page: of(viewers, (row) => Math.round(row.bytes)),
  bytes_a_second: of(viewers, (row) => Math.round(row.bytes / row.seconds)),
}));
console.table(table);
console.log(JSON.stringify(table));
