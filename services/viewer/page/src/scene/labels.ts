import type { Vector3 } from 'three';
import type { Viewport } from './viewport';

/** A name that stands at a place of the map. */
export interface Label {
  key: string;
  text: string;
  colour: string;
  at: Vector3;
}

/** Labels over a viewport, as text of the page: sharp, selectable by nobody, read by nobody twice. */
export class Labels {
  private readonly elements = new Map<string, HTMLElement>();

  constructor(private readonly viewport: Viewport) {}

  update(labels: Label[]): void {
    const seen = new Set<string>();
    for (const label of labels) {
      const place = this.viewport.project(label.at);
      if (!place) continue;
      seen.add(label.key);
      const element = this.element(label.key);
      if (element.textContent !== label.text) element.textContent = label.text;
      element.style.setProperty('--mark', label.colour);
      element.style.transform = `translate(${Math.round(place.x)}px, ${Math.round(place.y)}px)`;
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
