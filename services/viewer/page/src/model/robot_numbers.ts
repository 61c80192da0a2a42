const CATEGORIES = 8;

/**
 * Numbers robots so that each page gives a robot the same colour, whenever it was opened: a number in
 * the name counts, else its first letter; where two would be the same, the later name takes the next. Numbers beyond the categories are shades.
 */
export function numberRobots(robots: string[]): Map<string, number> {
  const numbers = new Map<string, number>();
  const taken = new Set<number>();
  for (const robot of [...robots].sort(byName)) {
    const number = free(wanted(robot), taken);
    taken.add(number);
    numbers.set(robot, number);
  }
  return numbers;
}

/**
 * Compares names by their bytes (UTF-8), runs of digits by their length first: "robot2" comes before "robot10", "Bravo" before
 * "alpha". The same as of NumberRobots() in slam/rendering/paint.h, so that pictures and exports have the page's colours.
 */
export function byName(a: string, b: string): number {
  const [left, right] = [bytesOf(a), bytesOf(b)];
  for (let at = 0; at < left.length && at < right.length; at++) {
    const [leftDigits, rightDigits] = [digitsAt(left, at), digitsAt(right, at)];
    if (leftDigits > 0 && rightDigits > 0 && leftDigits !== rightDigits) return leftDigits - rightDigits;
    if (left[at] !== right[at]) return left[at] - right[at];
  }
  return left.length - right.length;
}

const bytesOf = (text: string) => new TextEncoder().encode(text);

function digitsAt(bytes: Uint8Array, at: number): number {
  let end = at;
  while (bytes[end] >= 0x30 && bytes[end] <= 0x39) end++;
  return end - at;
}

/** The next number that nobody has; where all of one round are taken, the next round's. */
function free(wanted: number, taken: ReadonlySet<number>): number {
  for (let round = 0; ; round++) {
    for (let i = 0; i < CATEGORIES; i++) {
      const number = round * CATEGORIES + ((wanted + i) % CATEGORIES);
      if (!taken.has(number)) return number;
    }
  }
}

function wanted(robot: string): number {
  const digits = /(\d{1,9})\D*$/.exec(robot);
  if (digits) return Number(digits[1]) % CATEGORIES;
  const first = bytesOf(robot).at(0) ?? 0;
  const isUpper = first >= 0x41 && first <= 0x5a;
  return ((isUpper ? first + 0x20 : first) - 0x61 + 16 * CATEGORIES) % CATEGORIES;
}
