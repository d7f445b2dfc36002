// The JavaScript client as a package that Node finds, made of its sources.
import { mkdir, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const { VIEWER_SOURCES } = process.env;
const require = createRequire(join(VIEWER_SOURCES, 'package.json'));
const { build } = createRequire(require.resolve('vite'))('esbuild');
const CLIENT = join(VIEWER_SOURCES, '../../js/src');

export const ALIASES = { 'geodesicd-client/three': join(CLIENT, 'three.ts'), 'geodesicd-client': join(CLIENT, 'index.ts') };

// One three.js for both, the viewer's.
const oneThree = {
  name: 'one-three',
  setup({ onResolve, resolve }) {
    onResolve({ filter: /^three($|\/)/ }, ({ path, kind, pluginData }) =>
      pluginData === 'ours' ? undefined : resolve(path, { kind, resolveDir: VIEWER_SOURCES, pluginData: 'ours' }));
  },
};

/** A module and all that it imports in one text; bare names are found as the viewer's are. */
export async function bundle(text, platform = 'browser') {
  const { outputFiles } = await build({
    stdin: { contents: text, resolveDir: VIEWER_SOURCES, loader: 'js' },
    alias: ALIASES,
    plugins: [oneThree],
    bundle: true,
    format: 'esm',
    target: 'es2022',
    platform,
    write: false,
    logLevel: 'error',
  });
  return outputFiles[0].text;
}

/** Puts the package geodesicd-client below `folder`. */
export async function installClient(folder) {
  const place = join(folder, 'node_modules', 'geodesicd-client');
  await mkdir(place, { recursive: true });
  await writeFile(join(place, 'package.json'), '{"name":"geodesicd-client","type":"module","exports":"./index.js"}');
  await writeFile(join(place, 'index.js'), await bundle(`export * from 'geodesicd-client';`, 'node'));
}
