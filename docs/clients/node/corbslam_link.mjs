// What programs that follow robots and maps have in common; copy it beside yours: the services from the
// protos, credentials, streams that go on when a server was away, and poses that are composed.
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import grpc from "@grpc/grpc-js";
import protoLoader from "@grpc/proto-loader";

// Worth trying again: the server is away or ends, or the line broke.
const AWAY = new Set([grpc.status.UNAVAILABLE, grpc.status.RESOURCE_EXHAUSTED]);

// The services of the protos below `folder`, by name. An Error, in a sentence, where there are none.
export function loadServices(folder) {
  const files = ["corbslam/v1/map_store_service.proto", "corbslam/v1/agent_service.proto"];
  if (!existsSync(join(folder, files[0]))) {
    throw new Error(`${folder} has no ${files[0]}: --proto names the folder "proto" of the sources`);
  }
  const loaded = protoLoader.loadSync(files, {
    includeDirs: [folder], keepCase: true, longs: String, enums: String, defaults: true, oneofs: true,
  });
  return grpc.loadPackageDefinition(loaded).corbslam.v1;
}

function read(path) {
  if (!path) return null;
  try {
    return readFileSync(path);
  } catch (error) {
    throw new Error(`${path} can't be read: ${error.code}`);
  }
}

// With TLS if `ca` is given, and then by certificate, by token, or by neither. An Error, in a sentence,
// for what can't be meant. A token is read again for each call.
export function makeCredentials({ ca, cert, key, token }) {
  if (Boolean(cert) !== Boolean(key)) {
    throw new Error("a certificate needs its key, and a key its certificate: give --cert and --key, or neither");
  }
  if (!ca && (cert || token)) {
    throw new Error("without --ca there is no TLS, and nobody is told who you are: " +
      "give --ca, the file of the server's authority, too");
  }
  if (!ca) return grpc.credentials.createInsecure();
  const tls = grpc.credentials.createSsl(read(ca), read(key), read(cert));
  if (!token) return tls;
  read(token);
  const show = (_, done) => {
    const metadata = new grpc.Metadata();
    metadata.set("authorization", `Bearer ${readFileSync(token, "utf8").trim()}`);
    done(null, metadata);
  };
  return grpc.credentials.combineChannelCredentials(tls, grpc.credentials.createFromMetadataGenerator(show));
}

// The messages of a stream, and on where it broke: `call(request)` again, after 1, 2, 4, up to 15 s.
// `resume(request, message)` notes in the request what each message has told. Errors that are no use to
// try again are thrown. Leaving the loop cancels the call.
export async function* follow(call, request, resume = () => {}) {
  for (let failed = 0; ; ) {
    const stream = call(request);
    try {
      for await (const message of stream) {
        failed = 0;
        resume(request, message);
        yield message;
      }
      return;
    } catch (error) {
      if (!AWAY.has(error.code)) throw error;
      await sleep(1000 * Math.min(15, 2 ** failed++));
    } finally {
      stream.cancel();
    }
  }
}

const cross = (a, b) => [0, 1, 2].map((i) => a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]);

// The vector x, turned by a quaternion.
export function rotate([w, ...v], x) {
  const c = cross(v, x);
  const d = cross(v, c);
  return x.map((a, i) => a + 2 * (w * c[i] + d[i]));
}

// target_from_middle * middle_from_source, of Rigid and Similarity messages.
export function compose(a, b) {
  const scale = a.scale || 1;
  const [w, ...v] = a.rotation_wxyz;
  const [u, ...z] = b.rotation_wxyz;
  const c = cross(v, z);
  return {
    rotation_wxyz: [w * u - v.reduce((sum, x, i) => sum + x * z[i], 0), ...v.map((x, i) => w * z[i] + u * x + c[i])],
    translation: rotate(a.rotation_wxyz, b.translation).map((x, i) => scale * x + a.translation[i]),
    scale: scale * (b.scale || 1),
  };
}

// Where the camera of a WatchPoseResponse is in the shared frame; null while nobody knows.
export function globalFromCamera(pose) {
  if (!pose.local_from_camera || !pose.global_from_local) return null;
  return compose(pose.global_from_local, pose.local_from_camera);
}
