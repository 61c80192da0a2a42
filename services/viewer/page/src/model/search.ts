import { type KeyframeId, shortId } from './ids';
import type { MapNames } from './map_names';
import type { MapModel } from './map_model';
import { byName } from './robot_numbers';

/** Something that can be gone to. */
export type Found =
  | { kind: 'robot'; text: string; robot: string }
  | { kind: 'keyframe'; text: string; id: KeyframeId }
  | { kind: 'map'; text: string; localMap: string }
  | { kind: 'overlap'; text: string; number: bigint };

const MOST_FOUND = 12;

/** What is searched. */
export interface Searched {
  robots: readonly string[];
  model: MapModel;
  names: MapNames;
  overlaps: readonly { number: bigint; query: string; candidate: string }[];
}

/**
 * Robots by their name; "#12" or "alpha #12": keyframes; "alpha’s map 2" or an id: local maps;
 * "overlap 12": that one. A bare number is looked for among keyframes and overlaps.
 */
export function search(text: string, { robots, model, names, overlaps }: Searched): Found[] {
  const wanted = text.trim().toLowerCase().replaceAll('\'', '’');
  if (wanted === '') return [];
  const found: Found[] = [];
  for (const robot of robots) if (robot.toLowerCase().includes(wanted)) found.push({ kind: 'robot', text: robot, robot });
  const maps = [...model.localMaps.values()].filter(({ keyframes }) => keyframes.count > 0);
  for (const { id } of maps) {
    const name = names.of(id);
    if (name.toLowerCase().includes(wanted) || (wanted.length > 2 && id.includes(wanted))) found.push({ kind: 'map', text: `${name} (${shortId(id)})`, localMap: id });
  }
  const numbered = /^(.*?)\s*(?:#|keyframe\s+|kf\s*)?(\d{1,10})$/.exec(wanted);
  const overlap = /^(?:overlap\s*|o\s*)?(\d{1,10})$/.exec(wanted);
  if (overlap) {
    const one = overlaps.find(({ number }) => number === BigInt(overlap[1]));
    if (one) found.push({ kind: 'overlap', text: `Overlap ${one.number}: ${names.keyframe(one.query)} – ${names.keyframe(one.candidate)}`, number: one.number });
  }
  if (numbered && !/^o(verlap)?$/.test(numbered[1])) {
    const [of, index] = [numbered[1].trim(), Number(numbered[2])];
    const matching = maps.filter(({ id, agent, keyframes }) => keyframes.records.has(index)
      && (of === '' || agent.toLowerCase().includes(of) || names.of(id).toLowerCase().includes(of)));
    matching.sort((a, b) => byName(a.agent, b.agent));
    for (const { id } of matching) {
      found.push({ kind: 'keyframe', text: names.keyframe(`localMaps/${id}/keyframes/${index}`), id: { localMap: id, index } });
    }
  }
  return found.slice(0, MOST_FOUND);
}
