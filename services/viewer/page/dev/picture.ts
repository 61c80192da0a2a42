// A made-up picture of a street: sky, road and houses, as a bitmap that every browser decodes.
import { Random } from '../src/model/random';

const [WIDTH, HEIGHT, SCALE] = [503, 152, 1226 / 503];

export function picture(index: number): { type: string; body: Uint8Array; headers: Record<string, string> } {
  const rowBytes = 4 * Math.ceil((3 * WIDTH) / 4);
  const bytes = Buffer.alloc(54 + rowBytes * HEIGHT);
  bytes.write('BM');
  bytes.writeUInt32LE(bytes.length, 2);
  bytes.writeUInt32LE(54, 10);
  bytes.writeUInt32LE(40, 14);
  bytes.writeInt32LE(WIDTH, 18);
  bytes.writeInt32LE(-HEIGHT, 22);
  bytes.writeUInt16LE(1, 26);
  bytes.writeUInt16LE(24, 28);
  const random = new Random(index + 3);
  const houses = Array.from({ length: 12 }, () => ({ top: 20 + random.below(40), grey: 60 + random.below(120) }));
  for (let y = 0; y < HEIGHT; y++) {
    for (let x = 0; x < WIDTH; x++) {
      const { top, grey } = houses[Math.floor((12 * x) / WIDTH)];
      const isHouse = y > top && y < 95;
      const window = isHouse && x % 14 < 6 && y % 18 < 9 ? -40 : 0;
      const value = (isHouse ? grey + window : y <= top ? 225 : 110 - Math.floor((y - 95) / 3)) + random.below(9);
      bytes.fill(Math.max(0, Math.min(255, value)), 54 + y * rowBytes + 3 * x, 54 + y * rowBytes + 3 * x + 3);
    }
  }
  return { type: 'image/bmp', body: bytes, headers: { 'Picture-Scale': String(SCALE) } };
}
