/** A span of slots, `end` not included. */
export interface Span {
  start: number;
  end: number;
}

/** Which pages of a column changed since somebody looked, so that only these are sent to the GPU. */
export class DirtyPages {
  private readonly pages = new Set<number>();

  constructor(private readonly pageSlots = 256) {}

  mark(slot: number): void {
    this.pages.add(Math.floor(slot / this.pageSlots));
  }

  get any(): boolean {
    return this.pages.size > 0;
  }

  clear(): void {
    this.pages.clear();
  }

  /** The changed spans below a limit, neighbours joined; forgets them. */
  take(limit: number): Span[] {
    const spans: Span[] = [];
    for (const page of [...this.pages].sort((a, b) => a - b)) {
      const start = page * this.pageSlots;
      const end = Math.min(start + this.pageSlots, limit);
      if (start >= end) continue;
      const last = spans.at(-1);
      if (last?.end === start) last.end = end;
      else spans.push({ start, end });
    }
    this.pages.clear();
    return spans;
  }
}
