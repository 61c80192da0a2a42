// Makes dist/: the page, minified, and each file again as .gz.
import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { bundle } from './bundle.mjs';
import './generate.mjs';
import { outDir, page } from './paths.mjs';

const MOST_BYTES = 500_000;

rmSync(outDir, { recursive: true, force: true });
mkdirSync(outDir, { recursive: true });
await bundle({
  entryPoints: { app: join(page, 'src/main.ts') },
  outdir: outDir,
  minify: true,
  format: 'esm',
  target: 'es2022',
  legalComments: 'none',
});
await bundle({
  entryPoints: { app: join(page, 'src/style/app.css') },
  outdir: outDir,
  minify: true,
  target: 'es2022',
});
for (const name of ['index.html', 'favicon.svg']) cpSync(join(page, 'src', name), join(outDir, name));

let total = 0;
for (const name of readdirSync(outDir).sort()) {
  const packed = gzipSync(readFileSync(join(outDir, name)), { level: 9 });
  writeFileSync(join(outDir, `${name}.gz`), packed);
  total += packed.length;
  console.log(`${name}.gz ${packed.length} bytes`);
}
console.log(`page ${total} bytes compressed`);
if (total > MOST_BYTES) throw new Error(`the page weighs more than ${MOST_BYTES} bytes`);
