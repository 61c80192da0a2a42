/** Cuts a byte stream into messages, each preceded by its length as four bytes, least first. */
export class LengthPrefixed {
  private held = new Uint8Array(0);

  /** The messages that are whole with these bytes. */
  push(bytes: Uint8Array): Uint8Array[] {
    const all = this.held.length === 0 ? bytes : joined(this.held, bytes);
    const messages: Uint8Array[] = [];
    let at = 0;
    while (all.length - at >= 4) {
      const length = new DataView(all.buffer, all.byteOffset + at, 4).getUint32(0, true);
      if (all.length - at - 4 < length) break;
      messages.push(all.subarray(at + 4, at + 4 + length));
      at += 4 + length;
    }
    this.held = all.slice(at);
    return messages;
  }

  /** Bytes of a message that is not whole. */
  get rest(): number {
    return this.held.length;
  }
}

function joined(a: Uint8Array, b: Uint8Array): Uint8Array<ArrayBuffer> {
  const all = new Uint8Array(a.length + b.length);
  all.set(a);
  all.set(b, a.length);
  return all;
}
