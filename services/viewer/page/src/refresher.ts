/** Fetches something again when it is wanted, not more often than so, and never twice at once. */
export class Refresher {
  private isRunning = false;
  private isWanted = false;
  private isStopped = false;
  private lastMs = -Infinity;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(public everyMs: number, private readonly fetch: () => Promise<void>,
    private readonly onEnd: (error?: unknown) => void = () => {}) {}

  want(): void {
    this.isWanted = true;
    if (this.isStopped || this.isRunning || this.timer !== undefined) return;
    const waitMs = Math.max(0, this.lastMs + this.everyMs - performance.now());
    this.timer = setTimeout(() => void this.run(), waitMs);
  }

  stop(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.isStopped = true;
  }

  private async run(): Promise<void> {
    this.timer = undefined;
    this.isRunning = true;
    this.isWanted = false;
    this.lastMs = performance.now();
    try {
      await this.fetch();
      this.onEnd();
    } catch (error) {
      // What could not be fetched stays as it was.
      this.onEnd(error);
    }
    if (this.isStopped) return;
    this.isRunning = false;
    if (this.isWanted) this.want();
  }
}
