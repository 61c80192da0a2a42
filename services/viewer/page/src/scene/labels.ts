import type { Vector3 } from 'three';
import type { Viewport } from './viewport';

/** A name that stands at a place of the map. */
export interface Label {
  key: string;
  text: string;
  colour: string;
  at: Vector3;
  /** What a robot is doing: the style sheet has a mark for each. */
  doing?: string;
}

/** Where a label may go if others are in its place, by its own heights. */
const SHIFTS = [0, -1, 1, -2, 2];
const GAP_PX = 2;
/** How far above its place a label begins, as the style sheet has it. */
const ISLAND_LIFT_PX = 22;
const ROBOT_LIFT_PX = 8;

interface Rectangle {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

/** Labels over a viewport, as text of the page: sharp, selectable by nobody, read by nobody twice. */
export class Labels {
  private readonly elements = new Map<string, HTMLElement>();

  constructor(private readonly viewport: Viewport) {}

  update(labels: Label[]): void {
    const seen = new Set<string>();
    const taken: Rectangle[] = [];
    for (const label of labels) {
      const place = this.viewport.project(label.at);
      if (!place) continue;
      seen.add(label.key);
      const element = this.element(label.key);
      if (element.textContent !== label.text) element.textContent = label.text;
      element.style.setProperty('--mark', label.colour);
      if (element.dataset.doing !== (label.doing ?? '')) element.dataset.doing = label.doing ?? '';
      const y = freeHeight(element, place.x, place.y, taken);
      element.style.visibility = y === undefined ? 'hidden' : 'visible';
      element.style.transform = `translate(${Math.round(place.x)}px, ${Math.round(y ?? place.y)}px)`;
    }
    for (const [key, element] of this.elements) {
      if (seen.has(key)) continue;
      element.remove();
      this.elements.delete(key);
    }
  }

  private element(key: string): HTMLElement {
    let element = this.elements.get(key);
    if (!element) {
      element = document.createElement('div');
      element.className = key.startsWith('robot') ? 'label robot' : 'label island';
      element.setAttribute('aria-hidden', 'true');
      this.viewport.element.append(element);
      this.elements.set(key, element);
    }
    return element;
  }
}

/** Returns where a label is beside those that are there, and adds it to them; undefined: nowhere near. */
function freeHeight(element: HTMLElement, x: number, y: number, taken: Rectangle[]): number | undefined {
  const { offsetWidth: width, offsetHeight: height } = element;
  // An island's name is centred, a robot's begins at its mark; both only have to keep off each other.
  const isIsland = element.classList.contains('island');
  const left = isIsland ? x - width / 2 : x;
  const lift = isIsland ? ISLAND_LIFT_PX : ROBOT_LIFT_PX;
  for (const shift of SHIFTS) {
    const top = y + shift * (height + GAP_PX);
    const place = { left, top: top - lift, right: left + width, bottom: top - lift + height };
    if (taken.some((other) => overlap(place, other))) continue;
    taken.push(place);
    return top;
  }
  return undefined;
}

function overlap(a: Rectangle, b: Rectangle): boolean {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}
