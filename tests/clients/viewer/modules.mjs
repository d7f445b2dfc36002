// Modules of the viewer's that need no page, for Node.
import { createRequire } from 'node:module';
import { join } from 'node:path';

const { VIEWER_SOURCES } = process.env;
const { buildSync } = createRequire(createRequire(join(VIEWER_SOURCES, 'package.json')).resolve('vite'))('esbuild');

/** A module by the name of its file in src. */
export async function viewerModule(name) {
  const { outputFiles } = buildSync({
    entryPoints: [join(VIEWER_SOURCES, 'src', name)], bundle: true, write: false, format: 'esm', logLevel: 'error',
    alias: { 'geodesicd-client': join(VIEWER_SOURCES, '../../js/src/index.ts') },
  });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString('base64')}`);
}
