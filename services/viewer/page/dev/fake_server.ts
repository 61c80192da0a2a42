// Serves dist/ and a simulated mission by the contract that the page has with its server.
//   --port=8090 --robots=3 --token=SECRET
//   --big: at once 10,000 keyframes and 1,000,000 points, or as many as --points of each; --still: nobody drives; --steps=N: so many keyframes a robot at once
//   /dev/changes?rate=10&points=1000: so many points move so often a second; /dev/merge: two islands merge now
//   --drives: one robot's session is closed and thinned, and another robot only localises; --below=/map: a proxy has it below that path
//   --old: a store that does not tell which keyframes see a point
//   --merge=S,S: islands merge after so many seconds (default 12,20); --away=S: the store is away from then on for 5 s
import { createServer, type IncomingMessage, type ServerResponse } from 'node:http';
import { existsSync, readFileSync } from 'node:fs';
import { extname, join, resolve } from 'node:path';
import { type MessageInitShape, create, toBinary } from '@bufbuild/protobuf';
import { MapReset_Reason, ViewerMessageSchema } from '@gen/corbslam/v1/viewer_pb';
import { type WebSocket, WebSocketServer } from 'ws';
import { answer, listMissions, missionFacts, pulse } from './answers';
import { SimulatedMission } from './simulated_mission';

const flags = new Map<string, string>();
for (const flag of process.argv.slice(2)) {
  const [name, value = ''] = flag.replace(/^--/, '').split('=');
  flags.set(name, value);
}
const number = (name: string, otherwise: number) => Number(flags.get(name) ?? otherwise);
const dist = resolve(process.env.OUT_DIR ?? 'dist');
const isBig = flags.has('big');
const mission = new SimulatedMission('lab', number('robots', 3), number('points', isBig ? 100 : 60));
mission.isOld = flags.has('old');
if (isBig) mission.begin(3334);
else mission.drive(number('steps', 60));
mission.hasLocaliser = flags.has('drives');
if (flags.has('drives') && mission.robots[2]) mission.robots[2].isThinned = true;
const TYPES: Record<string, string> = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };
const POLICY = "default-src 'self'; img-src 'self' data:; style-src 'self'; connect-src 'self' ws: wss:";
const below = flags.get('below') ?? '';
const begunMs = Date.now();
const sockets = new Set<WebSocket>();

function refuse(response: ServerResponse, status: number, error: string): void {
  response.writeHead(status, { 'Content-Type': 'application/json' }).end(JSON.stringify({ error }));
}

function serveFile(path: string, response: ServerResponse): void {
  const file = join(dist, path === '/' ? 'index.html' : path.slice(1).replaceAll('..', ''));
  if (!existsSync(file)) return refuse(response, 404, 'There is no such page.');
  response.writeHead(200, { 'Content-Type': TYPES[extname(file)] ?? 'text/plain', 'Content-Encoding': 'gzip', 'Content-Security-Policy': POLICY });
  response.end(readFileSync(`${file}.gz`));
}

function serve(request: IncomingMessage, response: ServerResponse): void {
  const url = new URL(request.url ?? '/', 'http://localhost');
  if (!url.pathname.startsWith(`${below}/`)) return refuse(response, 404, 'There is nothing of this name.');
  url.pathname = url.pathname.slice(below.length);
  if (url.pathname.startsWith('/dev/')) return steer(url, response);
  if (!url.pathname.startsWith('/api/')) return serveFile(url.pathname, response);
  const token = flags.get('token');
  if (token && request.headers.authorization !== `Bearer ${token}`) return refuse(response, 401, 'This store wants a token.');
  const match = /^\/api\/missions(?:\/([^/]+)(\/.*)?)?$/.exec(decodeURI(url.pathname));
  if (match && match[1] && match[1] !== mission.name) return refuse(response, 404, 'There is no such mission.');
  const told = !match ? undefined : match[1] ? answer(mission, match[2] ?? '', url.searchParams) : listMissions([mission]);
  if (!told) return refuse(response, 404, 'There is nothing of this name.');
  response.writeHead(200, { 'Content-Type': told.type, ...told.headers }).end(told.body);
}

type Part = MessageInitShape<typeof ViewerMessageSchema>['part'];

function encode(part: Part): Uint8Array {
  return toBinary(ViewerMessageSchema, create(ViewerMessageSchema, { part }));
}

function send(socket: WebSocket, part: Part): void {
  socket.send(encode(part));
}

/** Encoding the large map takes longer than all else: a map that stands still is encoded before anybody comes. */
const kept = flags.has('still') ? [...mission.picture()].map((value) => encode({ case: 'map', value })) : undefined;

function sendPicture(socket: WebSocket): void {
  if (kept) for (const bytes of kept) socket.send(bytes);
  else for (const value of mission.picture()) send(socket, { case: 'map', value });
}

function welcome(socket: WebSocket): void {
  const { keyframes, mapPoints } = missionFacts(mission);
  send(socket, { case: 'reset', value: { reason: MapReset_Reason.BEGIN, keyframes, mapPoints } });
  sendPicture(socket);
  for (const value of mission.events) send(socket, { case: 'event', value });
  send(socket, { case: 'pulse', value: pulse(mission, true) });
  sockets.add(socket);
  socket.on('close', () => sockets.delete(socket));
}

const server = createServer(serve);
new WebSocketServer({ server, handleProtocols: () => 'corbslam' }).on('connection', (socket, request) => {
  const token = flags.get('token');
  if (token && !request.headers['sec-websocket-protocol']?.includes(`token.${token}`)) return socket.close(4401, 'token');
  if (!request.url?.startsWith(`${below}/stream/missions/${mission.name}?`)) return socket.close(4404, 'mission');
  return welcome(socket);
});
server.listen(number('port', 8090), () => console.log(`http://localhost:${number('port', 8090)}${below}/#mission=${mission.name}`));

/** Sends a change, and the events that came with it. */
function tell(change: () => ReturnType<SimulatedMission['drive']>): void {
  const before = mission.events.length;
  const value = change();
  for (const socket of sockets) {
    send(socket, { case: 'map', value });
    for (const event of mission.events.slice(before)) send(socket, { case: 'event', value: event });
  }
}

let changing: ReturnType<typeof setInterval> | undefined;

/** Does what a measurement asks for. */
function steer({ pathname, searchParams }: URL, response: ServerResponse): void {
  if (pathname === '/dev/merge') tell(() => mission.merge(1, 0));
  else if (pathname === '/dev/changes') {
    const [rate, points] = ['rate', 'points'].map((name) => Number(searchParams.get(name)));
    clearInterval(changing);
    if (rate > 0) changing = setInterval(() => tell(() => mission.move(points)), 1000 / rate);
  } else return refuse(response, 404, 'There is nothing of this name.');
  response.end();
}

const merges = (flags.get('merge') ?? '12,20').split(',').map(Number);
setInterval(() => {
  const seconds = (Date.now() - begunMs) / 1000;
  if (!flags.has('still')) tell(() => mission.drive(1));
  const next = mission.robots.findIndex(({ island }, i) => i > 0 && island === i);
  if (next > 0 && seconds > (merges[next - 1] ?? Infinity)) tell(() => mission.merge(next, 0));
}, 400);
setInterval(() => {
  const seconds = (Date.now() - begunMs) / 1000;
  const away = flags.has('away') && seconds > number('away', 0) && seconds < number('away', 0) + 5;
  for (const socket of sockets) send(socket, { case: 'pulse', value: pulse(mission, !away) });
}, 1000);
