const reduced = typeof matchMedia === 'function' ? matchMedia('(prefers-reduced-motion: reduce)') : undefined;

/** The person asked the system for as little motion as can be. */
export function wantsStillness(): boolean {
  return reduced?.matches ?? false;
}
