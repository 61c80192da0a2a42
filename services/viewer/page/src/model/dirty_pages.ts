/** A span of slots, `end` not included. */
export interface Span {
  start: number;
  end: number;
}

/** Which pages of a column changed since somebody looked, so that only these are sent to the GPU. */
export class DirtyPages {
  private flags = new Uint8Array(64);
  private isAny = false;

  constructor(private readonly pageSlots = 256) {}

  mark(slot: number): void {
    const page = Math.floor(slot / this.pageSlots);
    if (page >= this.flags.length) this.grow(page);
    this.flags[page] = 1;
    this.isAny = true;
  }

  get any(): boolean {
    return this.isAny;
  }

  clear(): void {
    this.flags.fill(0);
    this.isAny = false;
  }

  /** The changed spans below a limit, neighbours joined; forgets them. */
  take(limit: number): Span[] {
    if (!this.isAny) return [];
    const spans: Span[] = [];
    for (let page = 0; page * this.pageSlots < limit && page < this.flags.length; page++) {
      if (this.flags[page] === 0) continue;
      const start = page * this.pageSlots;
      const end = Math.min(start + this.pageSlots, limit);
      const last = spans.at(-1);
      if (last?.end === start) last.end = end;
      else spans.push({ start, end });
    }
    this.clear();
    return spans;
  }

  private grow(page: number): void {
    const { flags } = this;
    (this.flags = new Uint8Array(2 * (page + 1))).set(flags);
  }
}
