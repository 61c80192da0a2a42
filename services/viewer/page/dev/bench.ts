// How much processor time the page's script takes for the large map, without a browser: decoding and applying it,
// then changes of 1,000 points and of a keyframe of each robot, and a merge of two islands. Run with --changes=N.
import { toBinary } from '@bufbuild/protobuf';
import { type WatchMapResponse, WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { decodeMapChange } from '../src/feed/map_change';
import { MapModel } from '../src/model/map_model';
import { MapView } from '../src/scene/map_view';
import { SharedUniforms } from '../src/scene/materials';
import { SimulatedMission } from './simulated_mission';

const processorMs = () => process.cpuUsage().user / 1000;
const given = process.argv.find((argument) => argument.startsWith('--changes='));
const changes = Number(given?.split('=')[1] ?? 100);

function timed<T>(of: () => T): [number, T] {
  const begun = processorMs();
  const value = of();
  return [processorMs() - begun, value];
}

const mission = new SimulatedMission('lab', 3, 100);
mission.begin(3334);
const encode = (message: WatchMapResponse) => toBinary(WatchMapResponseSchema, message);
const messages = [...mission.picture()].map(encode);
const model = new MapModel();
const view = new MapView(new SharedUniforms());
const [decodingMs, decoded] = timed(() => messages.map((bytes) => decodeMapChange(bytes)));
const [applyingMs] = timed(() => { for (const message of decoded) model.apply([message]); });
const [showingMs, bytes] = timed(() => view.sync(model, [], 0));
console.log(`${messages.length} messages, ${messages.reduce((sum, { length }) => sum + length, 0)} bytes`);
console.log(`${model.keyframeCount} keyframes, ${model.pointCount} points, ${bytes} bytes for the GPU`);
console.log(`decoded in ${Math.round(decodingMs)} ms, applied in ${Math.round(applyingMs)} ms, handed to the scene in ${Math.round(showingMs)} ms`);

/** Takes changes over one by one, as the page does. */
function take(what: string, next: () => WatchMapResponse): void {
  const [ms, sizes]: number[][] = [[], []];
  for (let i = 0; i < changes; i++) {
    const told = encode(next());
    const [took, size] = timed(() => view.sync(model, model.apply([decodeMapChange(told)]), 0));
    ms.push(took);
    sizes.push(size);
  }
  const at = (values: number[], part: number) => [...values].sort((a, b) => a - b)[Math.floor(part * (values.length - 1))];
  console.log(`${what}: p50 ${at(ms, 0.5).toFixed(2)} ms, p99 ${at(ms, 0.99).toFixed(2)} ms, ${at(sizes, 0.5)} bytes for the GPU, ${changes} times`);
}

take('1,000 points that came together', () => mission.move(1000));
take('a keyframe of each robot with 100 points', () => mission.drive(1));
const merged = encode(mission.merge(1, 0));
const [mergeMs, mergeBytes] = timed(() => view.sync(model, model.apply([decodeMapChange(merged)]), 0));
console.log(`a merge of two islands: ${Math.round(mergeMs)} ms, ${merged.length} bytes received, ${mergeBytes} for the GPU`);
const blending: number[] = [];
for (let ms = 10; view.advance(ms); ms += 10) blending.push(timed(() => view.root.updateMatrixWorld(true))[0]);
console.log(`its blending: ${blending.length} frames, no byte for the GPU, ${(blending.reduce((a, b) => a + b, 0) / blending.length).toFixed(3)} ms of each`);
