import { h } from './dom';

/** Draws into a context whose units are the screen's pixels, with room for what is `size`; returns what it took. */
export type Draw = (context: CanvasRenderingContext2D, space: { width: number; height: number }, isLarge: boolean) => { width: number; height: number };

/** A canvas that a click shows as large as the window. */
export function enlargeable(label: string, draw: Draw): { button: HTMLButtonElement; redraw(): void } {
  const canvas = h('canvas', { class: 'seen', role: 'img', 'aria-label': label });
  const button = h('button', { class: 'enlarge', title: 'Enlarge', 'aria-label': `Enlarge: ${label}`, click: () => enlarge(label, draw) }, canvas);
  const redraw = () => paint(canvas, { width: button.clientWidth || 280, height: 300 }, draw, false);
  requestAnimationFrame(redraw);
  return { button, redraw };
}

function paint(canvas: HTMLCanvasElement, space: { width: number; height: number }, draw: Draw, isLarge: boolean): void {
  const ratio = Math.min(devicePixelRatio, 2);
  const context = canvas.getContext('2d')!;
  // What it takes is known once it was drawn; a canvas that is given a size is empty again.
  canvas.width = canvas.height = 1;
  const size = draw(context, space, isLarge);
  canvas.width = Math.ceil(size.width * ratio);
  canvas.height = Math.ceil(size.height * ratio);
  canvas.style.width = `${size.width}px`;
  canvas.style.height = `${size.height}px`;
  context.scale(ratio, ratio);
  draw(context, space, isLarge);
}

function enlarge(label: string, draw: Draw): void {
  const canvas = h('canvas', { class: 'seen', role: 'img', 'aria-label': label });
  const dialog = h('dialog', { class: 'enlarged', 'aria-label': label },
    canvas, h('p', { class: 'quiet' }, label),
    h('form', { method: 'dialog' }, h('button', { autofocus: true }, 'Close')));
  const fill = () => paint(canvas, { width: innerWidth - 64, height: innerHeight - 150 }, draw, true);
  dialog.addEventListener('click', (event) => event.target === dialog && dialog.close());
  dialog.addEventListener('close', () => {
    removeEventListener('resize', fill);
    dialog.remove();
  });
  addEventListener('resize', fill);
  document.body.append(dialog);
  dialog.showModal();
  fill();
}
