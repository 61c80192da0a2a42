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

/** "robot2" comes before "robot10". */
export function byName(a: string, b: string): number {
  return a.localeCompare(b, 'en', { numeric: true });
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
  return ((robot.toLowerCase().codePointAt(0) ?? 0) - 'a'.codePointAt(0)! + 16 * CATEGORIES) % CATEGORIES;
}
