// Bundles the unit tests and runs them with node's test runner.
import { spawnSync } from 'node:child_process';
import { mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { bundle } from './bundle.mjs';
import './generate.mjs';
import { page } from './paths.mjs';

const out = join(page, 'out/test');
mkdirSync(out, { recursive: true });
const tests = readdirSync(join(page, 'test')).filter((name) => name.endsWith('_test.ts'));
await bundle({
  entryPoints: tests.map((name) => join(page, 'test', name)),
  outdir: out,
  outExtension: { '.js': '.mjs' },
  platform: 'node',
  format: 'esm',
  sourcemap: 'inline',
});
const files = tests.map((name) => join(out, name.replace(/\.ts$/, '.mjs')));
process.exit(spawnSync(process.execPath, ['--enable-source-maps', '--test', ...files], { stdio: 'inherit' }).status ?? 1);
