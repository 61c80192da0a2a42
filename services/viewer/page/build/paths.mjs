// Where the build reads and writes. PROTO_DIR and OUT_DIR come from the environment when another
// build system drives this one.
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

export const page = resolve(dirname(fileURLToPath(import.meta.url)), '..');
export const protoDir = resolve(process.env.PROTO_DIR ?? join(page, '../../../proto'));
export const outDir = resolve(process.env.OUT_DIR ?? join(page, 'dist'));
export const genDir = process.env.OUT_DIR ? join(dirname(outDir), 'page_gen') : join(page, 'gen');
