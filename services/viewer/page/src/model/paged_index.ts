const PAGE = 4096;

/** From numbers that mostly follow each other to small numbers; far smaller and faster than a Map. */
export class PagedIndex {
  size = 0;
  private pages = new Map<number, Int32Array>();
  private lastNumber = -1;
  private lastPage: Int32Array | undefined;

  get(key: number): number | undefined {
    const value = this.page(Math.floor(key / PAGE))?.[key % PAGE] ?? 0;
    return value === 0 ? undefined : value - 1;
  }

  set(key: number, value: number): void {
    const number = Math.floor(key / PAGE);
    let page = this.page(number);
    if (!page) {
      page = new Int32Array(PAGE);
      this.pages.set(number, page);
      this.lastPage = page;
    }
    if (page[key % PAGE] === 0) this.size++;
    page[key % PAGE] = value + 1;
  }

  delete(key: number): void {
    const page = this.page(Math.floor(key / PAGE));
    if (!page || page[key % PAGE] === 0) return;
    page[key % PAGE] = 0;
    this.size--;
  }

  copy(): PagedIndex {
    const other = new PagedIndex();
    other.size = this.size;
    for (const [number, page] of this.pages) other.pages.set(number, page.slice());
    return other;
  }

  private page(number: number): Int32Array | undefined {
    if (number !== this.lastNumber) {
      this.lastNumber = number;
      this.lastPage = this.pages.get(number);
    }
    return this.lastPage;
  }
}
