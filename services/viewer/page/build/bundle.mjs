// The one way in which this page's TypeScript is bundled.
import { join } from 'node:path';
import { build } from 'esbuild';
import { genDir, page } from './paths.mjs';

export function bundle(options) {
  return build({
    bundle: true,
    absWorkingDir: page,
    alias: { '@gen': genDir },
    nodePaths: [join(page, 'node_modules')],
    logLevel: 'warning',
    ...options,
  });
}
