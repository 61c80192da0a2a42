// Asks a map store what it has, follows a mission's map, and follows a robot's pose.
//
//   node client.mjs STORE                                its missions
//   node client.mjs STORE --mission lab --messages 3     the mission's map, as it grows
//   node client.mjs STORE --mission lab --picture hall.png --camera "517.3 516.5 318.6 255.3"
//   node client.mjs STORE --mission lab --events         what happened in the mission, and what happens
//   node client.mjs ROBOT --pose --messages 3            where a robot is; ROBOT is its --listen
//   node client.mjs ROBOT --pose --events                what changes for whoever follows the pose
//
// docs/clients.md says what the words mean. --proto names the folder with corbslam/v1.
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { parseArgs, promisify } from "node:util";
import grpc from "@grpc/grpc-js";
import { follow, globalFromCamera, loadServices, makeCredentials } from "./corbslam_link.mjs";

const string = { type: "string" };
const { values: args, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    ca: string, cert: string, key: string, token: string, mission: string, picture: string,
    camera: string, pose: { type: "boolean" }, events: { type: "boolean" },
    messages: { type: "string", default: "3" },
    proto: { type: "string", default: fileURLToPath(new URL("../../../proto", import.meta.url)) },
  },
});
const [address] = positionals;

// Shows the first --messages of a stream.
async function take(messages, show) {
  let left = Number(args.messages);
  for await (const message of messages) {
    show(message);
    if (--left <= 0) return;
  }
}

async function listMissions(store) {
  const list = promisify(store.ListMissions.bind(store));
  let page_token = "";
  do {
    const page = await list({ page_size: 100, page_token });
    for (const mission of page.missions) {
      console.log(`${mission.name}: ${mission.keyframes} keyframes, ${mission.islands} islands`);
    }
    page_token = page.next_page_token;
  } while (page_token);
}

async function findPicture(store, mission) {
  if (!args.camera) throw new Error('--picture needs --camera "FX FY CX CY"');
  // Behind the first four k1 k2 p1 p2 k3 of the lens, if it distorts.
  const [fx_px, fy_px, cx_px, cy_px, ...distortion] = args.camera.split(" ").map(Number);
  const camera = { fx_px, fy_px, cx_px, cy_px, distortion };
  const picture = { encoded: readFileSync(args.picture), camera };
  const answer = await promisify(store.Localize.bind(store))({ mission, picture });
  console.log(answer.stage, `${answer.inliers} points agree`);
  if (answer.camera_from_island) console.log("camera_from_island", answer.camera_from_island);
}

const showEvent = (event) => console.log(event.number, event.kind ?? event.event, event.local_map ?? "");
const afterLast = (request, event) => { request.after_number = event.number; };

function watchRobot(robot) {
  if (args.events) return take(follow((request) => robot.WatchEvents(request), {}, afterLast), showEvent);
  return take(follow((request) => robot.WatchPose(request), { max_rate_hz: 5 }), (pose) =>
    console.log(pose.timestamp_ns, pose.state, pose.local_from_camera?.translation,
      "in the shared frame:", globalFromCamera(pose)?.translation ?? "not known"));
}

function watchMap(store, mission) {
  // Of a change in several messages the last one is the whole.
  const resume = (request, change) => { if (!change.continues) request.from_version = change.version; };
  return take(follow((request) => store.WatchMap(request), { mission }, resume), (change) => {
    const keyframes = change.islands.reduce((sum, island) => sum + island.keyframes.length, 0);
    console.log(`version ${change.version}: ${keyframes} keyframes came or moved`);
  });
}

async function main() {
  if (!address) throw new Error("the address of a store or of a robot is missing, as 127.0.0.1:50051");
  const { MapStore, Agent } = loadServices(args.proto);
  const credentials = makeCredentials(args);
  if (args.pose) return watchRobot(new Agent(address, credentials));
  const store = new MapStore(address, credentials);
  if (!args.mission) return listMissions(store);
  const mission = `missions/${args.mission}`;
  if (args.picture) return findPicture(store, mission);
  if (args.events) return take(follow((request) => store.WatchEvents(request), { mission }, afterLast), showEvent);
  return watchMap(store, mission);
}

main().then(() => process.exit(0), (error) => {
  console.error(error.details ? `${grpc.status[error.code]}: ${error.details}` : error.message);
  process.exit(1);
});
