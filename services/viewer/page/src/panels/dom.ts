type Child = Node | string | undefined | false;
type Attributes = Record<string, string | boolean | EventListener | undefined>;

/** Makes an element. Strings become text nodes, always. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, '');
    else if (typeof value === 'string') element.setAttribute(name, value);
  }
  element.append(...children.filter((child): child is Node | string => child !== undefined && child !== false));
  return element;
}

/** Says words anew only where they are others: screen readers read what changes. */
export function setText(element: HTMLElement, words: string): void {
  if (element.textContent !== words) element.textContent = words;
}

/** A coloured mark; the style sheet draws it. */
export function swatch(colour: string): HTMLElement {
  const mark = h('span', { class: 'swatch', 'aria-hidden': 'true' });
  mark.style.setProperty('--mark', colour);
  return mark;
}

/** Rows of names and values. */
export function table(rows: [string, string | Node][]): HTMLElement {
  const body = h('dl', { class: 'facts' });
  for (const [name, value] of rows) body.append(h('dt', {}, name), h('dd', {}, value));
  return body;
}

/** A part of the side with a heading. */
export function panel(id: string, title: string): { root: HTMLElement; body: HTMLElement } {
  const body = h('div', { class: 'body' });
  const root = h('section', { id, class: 'panel', 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), body);
  return { root, body };
}

/** Replaces content only where its words changed, so that focus and selection stay. */
export function refill(body: HTMLElement, key: string, fill: () => Node[]): void {
  if (body.dataset.key === key) return;
  const focused = document.activeElement instanceof HTMLElement && body.contains(document.activeElement)
    ? document.activeElement.dataset.focus : undefined;
  body.dataset.key = key;
  body.replaceChildren(...fill());
  if (focused) body.querySelector<HTMLElement>(`[data-focus="${CSS.escape(focused)}"]`)?.focus();
}
