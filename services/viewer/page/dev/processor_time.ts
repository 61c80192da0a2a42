// Processor time of a program's processes (Linux), however long they had to wait for it.
import { readFileSync, readdirSync } from 'node:fs';

function read(path: string): string {
  try {
    return readFileSync(path, 'utf8');
  } catch {
    return '';
  }
}

function processes(): number[] {
  return readdirSync('/proc').filter((name) => /^\d+$/.test(name)).map(Number);
}

/** The processes that this one started, and those that they started. */
function descendants(of: number, all = processes()): number[] {
  const parent = (pid: number) => Number(read(`/proc/${pid}/stat`).replace(/^.*\) /s, '').split(' ')[1]);
  const children = all.filter((pid) => parent(pid) === of);
  return children.flatMap((child) => [child, ...descendants(child, all)]);
}

/** Milliseconds so far, by Chromium's kinds of process ("gpu-process", "renderer"). */
export function processorMs(): Record<string, number> {
  const kinds: Record<string, number> = {};
  for (const pid of descendants(process.pid)) {
    const kind = /--type=([a-z-]+)/.exec(read(`/proc/${pid}/cmdline`))?.[1];
    if (!kind) continue;
    // schedstat begins with the nanoseconds that a thread ran.
    for (const thread of readdirSync(`/proc/${pid}/task`)) {
      kinds[kind] = (kinds[kind] ?? 0) + Number(read(`/proc/${pid}/task/${thread}/schedstat`).split(' ')[0]) / 1e6;
    }
  }
  return kinds;
}
