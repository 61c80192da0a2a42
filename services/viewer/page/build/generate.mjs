// Generates TypeScript from the protocol's files.
import { execFileSync } from 'node:child_process';
import { mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { genDir, page, protoDir } from './paths.mjs';

// All of them: what one imports can't be left out. The bundler drops what the page doesn't use.
const files = readdirSync(join(protoDir, 'corbslam/v1')).filter((name) => name.endsWith('.proto')).sort();

mkdirSync(genDir, { recursive: true });
execFileSync(process.env.PROTOC ?? 'protoc', [
  `--plugin=protoc-gen-es=${join(page, 'node_modules/.bin/protoc-gen-es')}`,
  `-I${protoDir}`,
  `--es_out=${genDir}`,
  '--es_opt=target=ts',
  ...files.map((name) => `corbslam/v1/${name}`),
], { cwd: protoDir, stdio: 'inherit' });
