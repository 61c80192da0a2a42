import type { MissionAgent } from '@gen/corbslam/v1/resources_pb';
import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import { doingOf } from './model/activity';
import { lastSegment } from './model/ids';
import { poseOfCamera } from './model/pose';
import type { Vec3 } from './model/vector';
import type { MapView } from './scene/map_view';
import type { RobotNow } from './scene_labels';

/** What the newest pulse says of robots, for their marks in the map; nothing while it is not how things are. */
export class RobotsNow {
  private pulse: MissionPulse | undefined;
  private seen = '';

  constructor(private readonly map: MapView, private readonly lastLocalised: (robot: string) => { island: string; place: Vec3 } | undefined) {}

  /** Takes the pulse over; undefined: it says nothing of what is shown. Returns whether a mark is another one. */
  take(pulse: MissionPulse | undefined): boolean {
    this.pulse = pulse;
    const seen = JSON.stringify((pulse?.agents ?? []).map((agent) => [
      agent.name, doingOf(agent).doing, agent.localiseOnly ? Number(agent.lastPose?.timestampNs ?? 0n) : 0]));
    const isOther = seen !== this.seen;
    this.seen = seen;
    return isOther;
  }

  of(robot: string): RobotNow {
    const agent = this.pulse?.agents.find(({ name }) => lastSegment(name) === robot);
    return { doing: doingOf(agent).doing, at: (agent?.localiseOnly && this.placeOf(agent)) || (agent?.localMaps.length === 0 ? this.endOf(robot) : undefined) };
  }

  /** One that has localised, and whose pose the store does not tell any more. */
  private endOf(robot: string) {
    const last = this.lastLocalised(robot);
    return last && this.map.worldOf(last.island, last.place);
  }

  /** A robot that only localises has no keyframes: it says itself where it is. */
  private placeOf({ lastPose }: MissionAgent) {
    const pose = lastPose && poseOfCamera(lastPose.cameraFromIsland);
    return pose && this.map.worldOf(lastSegment(lastPose.island), pose.centre);
  }
}
