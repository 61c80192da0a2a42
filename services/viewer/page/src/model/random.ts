/** Whole numbers that look random and come again with the same seed (xorshift, 32 bits). */
export class Random {
  constructor(private state = 0x9e3779b9) {}

  /** From 0 up to, without, the limit. */
  below(limit: number): number {
    let x = this.state;
    x ^= x << 13;
    x ^= x >>> 17;
    x ^= x << 5;
    this.state = x >>> 0;
    return Math.floor((this.state / 0x100000000) * limit);
  }
}
