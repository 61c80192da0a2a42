// Bundles one program of dev/ and runs it with the rest of the arguments.
import { spawnSync } from 'node:child_process';
import { basename, join } from 'node:path';
import { bundle } from './bundle.mjs';
import { page } from './paths.mjs';

const [source, ...rest] = process.argv.slice(2);
const file = join(page, 'out', basename(source).replace(/\.ts$/, '.mjs'));
await bundle({
  entryPoints: [join(page, source)],
  outfile: file,
  platform: 'node',
  format: 'esm',
  external: ['playwright-core', 'ws'],
});
if (rest.includes('--bundle-only')) process.exit(0);
process.exit(spawnSync(process.execPath, [file, ...rest], { stdio: 'inherit' }).status ?? 1);
