import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import { lastSegment, parseKeyframeName, shortId } from './ids';

/** What people call local maps: their robot's, by the numbers that the store gives them for good. */
export class MapNames {
  private readonly known = new Map<string, { agent: string; number: number }>();
  /** Grows with each name that came. */
  version = 0;

  learn({ localMaps }: Pick<MissionPulse, 'localMaps'>): void {
    for (const { name, agent, number, joinedLocalMaps, joinedNumbers } of localMaps) {
      this.note(lastSegment(name), lastSegment(agent), number);
      // Sessions that became parts of another one keep the numbers that they had.
      joinedLocalMaps.forEach((part, i) => this.note(lastSegment(part), lastSegment(agent), joinedNumbers[i] ?? 0));
    }
  }

  /** "alpha’s map 2". */
  of(id: string): string {
    const agent = this.known.get(id)?.agent;
    return agent ? `${agent}’s ${this.ownOf(id)}` : `map ${shortId(id)}`;
  }

  /** A keyframe by its resource name: "alpha #12", or of a robot with several local maps "alpha’s map 2 #12". */
  keyframe(name: string): string {
    const id = parseKeyframeName(name);
    if (!id) return name;
    const agent = this.known.get(id.localMap)?.agent;
    const others = [...this.known.values()].filter((one) => one.agent === agent).length;
    return `${agent && others === 1 ? agent : this.of(id.localMap)} #${id.index}`;
  }

  /** "map 2", where it is said whose. */
  ownOf(id: string): string {
    const number = this.known.get(id)?.number;
    return number ? `map ${number}` : `map ${shortId(id)}`;
  }

  private note(id: string, agent: string, number: number): void {
    const before = this.known.get(id);
    if (before?.agent === agent && before.number === number) return;
    this.known.set(id, { agent, number });
    this.version++;
  }
}
