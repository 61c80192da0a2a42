// How much processor time the page's model takes for the large map, without drawing: decoding and applying.
import { toBinary } from '@bufbuild/protobuf';
import { WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { decodeMapChange } from '../src/feed/map_change';
import { MapModel } from '../src/model/map_model';
import { SimulatedMission } from './simulated_mission';

const mission = new SimulatedMission('lab', 3, 100);
mission.begin(3334);
const messages = [...mission.picture()].map((message) => toBinary(WatchMapResponseSchema, message));
const model = new MapModel();
const processorMs = () => process.cpuUsage().user / 1000;
const begun = processorMs();
const decoded = messages.map((bytes) => decodeMapChange(bytes));
const between = processorMs();
for (const message of decoded) model.apply([message]);
console.log(`${messages.length} messages, ${messages.reduce((sum, { length }) => sum + length, 0)} bytes`);
console.log(`${model.keyframeCount} keyframes, ${model.pointCount} points`);
console.log(`decoded in ${Math.round(between - begun)} ms, applied in ${Math.round(processorMs() - between)} ms`);
