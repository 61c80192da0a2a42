/** Fetches something again when it is wanted, not more often than so, and never twice at once. */
export class Refresher {
  private isRunning = false;
  private isWanted = false;
  private lastMs = -Infinity;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly everyMs: number, private readonly fetch: () => Promise<void>) {}

  want(): void {
    this.isWanted = true;
    if (this.isRunning || this.timer !== undefined) return;
    const waitMs = Math.max(0, this.lastMs + this.everyMs - performance.now());
    this.timer = setTimeout(() => void this.run(), waitMs);
  }

  stop(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.isRunning = true;
  }

  private async run(): Promise<void> {
    this.timer = undefined;
    this.isRunning = true;
    this.isWanted = false;
    this.lastMs = performance.now();
    try {
      await this.fetch();
    } catch {
      // What could not be fetched stays as it was; the connection's banner says why.
    }
    this.isRunning = false;
    if (this.isWanted) this.want();
  }
}
