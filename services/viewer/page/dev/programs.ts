// Starts the project's programs for a walk through the page.
import { type ChildProcess, spawn } from 'node:child_process';
import { createWriteStream } from 'node:fs';
import { join } from 'node:path';

/** Where the programs are, and where their logs go. */
export interface Places {
  programs: string;
  logs: string;
}

/** Returns what follows --name on the command line. */
export function option(name: string, otherwise?: string): string {
  const at = process.argv.indexOf(`--${name}`);
  if (at >= 0) return process.argv[at + 1];
  if (otherwise === undefined) throw new Error(`--${name} is missing`);
  return otherwise;
}

/** Starts a program; `address` is what it says to listen on. */
export class Program {
  address = '';
  private readonly child: ChildProcess;
  private readonly ended: Promise<void>;

  constructor(readonly name: string, args: string[], private readonly places: Places) {
    this.child = spawn(join(places.programs, name), args, { stdio: ['ignore', 'pipe', 'pipe'] });
    this.child.stderr!.pipe(createWriteStream(join(places.logs, `${name}.log`), { flags: 'a' }));
    this.ended = new Promise((done) => this.child.once('exit', () => done()));
  }

  get pid(): number { return this.child.pid!; }

  async listening(): Promise<string> {
    for await (const chunk of this.child.stdout!) {
      const found = /listening on (\S+)/.exec(String(chunk));
      if (!found) continue;
      this.child.stdout!.resume();
      return (this.address = found[1]);
    }
    throw new Error(`${this.name} ended before it listened; ${this.places.logs}/${this.name}.log says why`);
  }

  end(): Promise<void> { return this.ended; }

  async stop(): Promise<void> {
    this.child.kill('SIGTERM');
    await this.ended;
  }
}

export async function start(name: string, args: string[], places: Places): Promise<Program> {
  const program = new Program(name, args, places);
  await program.listening();
  return program;
}
