// Asks a map store what it has, follows a mission's map, and follows a robot's pose.
//
//   node client.mjs STORE                                its missions
//   node client.mjs STORE --mission lab --messages 3     the mission's map, as it grows
//   node client.mjs STORE --mission lab --picture hall.png --camera "517.3 516.5 318.6 255.3"
//   node client.mjs ROBOT --pose --messages 3            where a robot is; ROBOT is its --listen
//
// docs/clients.md says what the words mean. --proto names the folder with corbslam/v1.
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { parseArgs, promisify } from "node:util";
import grpc from "@grpc/grpc-js";
import protoLoader from "@grpc/proto-loader";

const string = { type: "string" };
const { values: args, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    ca: string, cert: string, key: string, token: string, mission: string, picture: string,
    camera: string, pose: { type: "boolean" }, messages: { type: "string", default: "3" },
    proto: { type: "string", default: fileURLToPath(new URL("../../../proto", import.meta.url)) },
  },
});
const [address] = positionals;

const loaded = protoLoader.loadSync(
  ["corbslam/v1/map_store_service.proto", "corbslam/v1/agent_service.proto"],
  { includeDirs: [args.proto], keepCase: true, longs: String, enums: String, defaults: true },
);
const { MapStore, Agent } = grpc.loadPackageDefinition(loaded).corbslam.v1;

// With TLS if --ca is given, and then by certificate, by token, or by neither.
function credentials() {
  if (!args.ca) return grpc.credentials.createInsecure();
  const read = (path) => (path ? readFileSync(path) : null);
  const tls = grpc.credentials.createSsl(read(args.ca), read(args.key), read(args.cert));
  if (!args.token) return tls;
  const show = (_, done) => {
    const metadata = new grpc.Metadata();
    metadata.set("authorization", `Bearer ${readFileSync(args.token, "utf8").trim()}`);
    done(null, metadata);
  };
  return grpc.credentials.combineChannelCredentials(
    tls, grpc.credentials.createFromMetadataGenerator(show));
}

// Calls `show` for the first --messages of a stream, then cancels it.
async function take(stream, show) {
  let left = Number(args.messages);
  for await (const message of stream) {
    show(message);
    if (--left <= 0) break;
  }
  stream.cancel();
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
  // Behind the first four k1 k2 p1 p2 k3 of the lens, if it distorts.
  const [fx_px, fy_px, cx_px, cy_px, ...distortion] = args.camera.split(" ").map(Number);
  const camera = { fx_px, fy_px, cx_px, cy_px, distortion };
  const picture = { encoded: readFileSync(args.picture), camera };
  const answer = await promisify(store.Localize.bind(store))({ mission, picture });
  console.log(answer.stage, `${answer.inliers} points agree`);
  if (answer.camera_from_island) console.log("camera_from_island", answer.camera_from_island);
}

async function main() {
  if (args.pose) {
    const robot = new Agent(address, credentials());
    return take(robot.WatchPose({ max_rate_hz: 5 }), (pose) =>
      console.log(pose.timestamp_ns, pose.state, pose.local_from_camera?.translation));
  }
  const store = new MapStore(address, credentials());
  if (!args.mission) return listMissions(store);
  const mission = `missions/${args.mission}`;
  if (args.picture) return findPicture(store, mission);
  return take(store.WatchMap({ mission }), (change) => {
    const keyframes = change.islands.reduce((sum, island) => sum + island.keyframes.length, 0);
    console.log(`version ${change.version}: ${keyframes} keyframes came or moved`);
  });
}

main().then(() => process.exit(0), (error) => {
  console.error(`${grpc.status[error.code] ?? "error"}: ${error.details ?? error.message}`);
  process.exit(1);
});
