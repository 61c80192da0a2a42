/** Reads the protocol buffers' wire format, as far as columns of points need it. */
export class WireReader {
  constructor(readonly bytes: Uint8Array, public at = 0, readonly end = bytes.length) {}

  get isDone(): boolean {
    return this.at >= this.end;
  }

  /** A varint; exact up to 2^53, which no column that is read here goes beyond. */
  varint(): number {
    let value = 0;
    let factor = 1;
    for (;;) {
      if (this.at >= this.end) throw new RangeError('a varint is cut off');
      const byte = this.bytes[this.at++];
      value += (byte & 127) * factor;
      if (byte < 128) return value;
      factor *= 128;
    }
  }

  zigzag(): number {
    const value = this.varint();
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  }

  /** A length-delimited field's content. */
  part(): WireReader {
    const length = this.varint();
    const begin = this.at;
    this.at = begin + length;
    if (this.at > this.end) throw new RangeError('a field is cut off');
    return new WireReader(this.bytes, begin, this.at);
  }

  skip(wireType: number): void {
    if (wireType === 0) this.varint();
    else if (wireType === 1) this.at += 8;
    else if (wireType === 2) this.part();
    else if (wireType === 5) this.at += 4;
    else throw new RangeError(`wire type ${wireType} is not known`);
  }

  get content(): Uint8Array {
    return this.bytes.subarray(this.at, this.end);
  }
}

/** Calls back with each field's number, wire type and first byte; the callback reads or skips it. */
export function forEachField(reader: WireReader, callback: (field: number, wireType: number, begin: number) => void): void {
  while (!reader.isDone) {
    const begin = reader.at;
    const tag = reader.varint();
    callback(Math.floor(tag / 8), tag % 8, begin);
  }
}

export function joinBytes(parts: Uint8Array[]): Uint8Array {
  const all = new Uint8Array(parts.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** A length-delimited field. */
export function lengthDelimited(field: number, content: Uint8Array): Uint8Array {
  const head: number[] = [];
  for (let value of [field * 8 + 2, content.length]) {
    for (; value > 127; value = Math.floor(value / 128)) head.push((value % 128) + 128);
    head.push(value);
  }
  return joinBytes([Uint8Array.from(head), content]);
}
