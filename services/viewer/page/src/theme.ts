import type { Theme } from './model/palette';

const prefersDark = matchMedia('(prefers-color-scheme: dark)');

/** Sets the page's theme; returns which one it is. */
export function applyTheme(wanted: Theme | 'auto'): Theme {
  const theme = wanted === 'auto' ? (prefersDark.matches ? 'dark' : 'light') : wanted;
  document.documentElement.dataset.theme = theme;
  return theme;
}

export function onSystemTheme(callback: () => void): void {
  prefersDark.addEventListener('change', callback);
}
