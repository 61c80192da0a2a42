// Generates TypeScript from the protocol's files.
import { execFileSync } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { genDir, page, protoDir } from './paths.mjs';

const files = [
  'viewer', 'events', 'map_store_service', 'resources', 'overlap', 'items', 'geometry',
  'agent_service', 'map_update', 'shared_update',
];

mkdirSync(genDir, { recursive: true });
execFileSync(process.env.PROTOC ?? 'protoc', [
  `--plugin=protoc-gen-es=${join(page, 'node_modules/.bin/protoc-gen-es')}`,
  `-I${protoDir}`,
  `--es_out=${genDir}`,
  '--es_opt=target=ts',
  ...files.map((name) => `corbslam/v1/${name}.proto`),
], { cwd: protoDir, stdio: 'inherit' });
