import type { Found } from '../model/search';
import { h } from './dom';

/** The box in which people search, and what was found. */
export class FindBox {
  readonly root: HTMLElement;
  private readonly input = h('input', {
    type: 'search', placeholder: 'Find robot, #keyframe, map, overlap', 'aria-label': 'Find a robot, keyframe, local map or overlap (/)',
    autocomplete: 'off', spellcheck: 'false',
  });
  private readonly list = h('ul', { class: 'found', 'aria-label': 'Found' });

  constructor(private readonly search: (text: string) => Found[], private readonly goTo: (found: Found) => void) {
    this.root = h('form', { class: 'find', role: 'search', submit: (event: Event) => this.first(event) }, this.input, this.list);
    this.list.hidden = true;
    this.input.addEventListener('input', () => this.show());
    this.input.addEventListener('keydown', (event) => {
      if (event.key !== 'Escape') return;
      this.close();
      this.input.blur();
    });
  }

  focus(): void {
    this.input.focus();
    this.input.select();
  }

  private first(event: Event): void {
    event.preventDefault();
    const [found] = this.search(this.input.value);
    if (found) this.choose(found);
  }

  private show(): void {
    const found = this.search(this.input.value);
    this.list.hidden = this.input.value.trim() === '';
    this.list.replaceChildren(...(found.length === 0 ? [h('li', { class: 'quiet' }, 'Nothing of this name is shown.')]
      : found.map((one) => h('li', {}, h('button', { type: 'button', click: () => this.choose(one) }, one.text)))));
  }

  private choose(found: Found): void {
    this.close();
    this.input.blur();
    this.goTo(found);
  }

  private close(): void {
    this.input.value = '';
    this.list.hidden = true;
    this.list.replaceChildren();
  }
}
