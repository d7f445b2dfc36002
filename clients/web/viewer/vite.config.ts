/**
 * How the page is built: files with hashed names under assets/, nothing inline, so that
 * it runs under the server's policy (scripts and styles from itself only). While one
 * develops, /v1 goes to a geodesicd whose address is in GEODESICD_URL.
 */
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vite';

const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));
// The Host header stays as the browser sent it: a page may change meshes if its origin's
// host is the one that the request is for.
const server = {
  target: process.env['GEODESICD_URL'] ?? 'http://127.0.0.1:8080',
  changeOrigin: false,
};

export default defineConfig({
  // A proxy may have the page under a path of its own: everything is asked for from there.
  base: './',
  resolve: {
    alias: [
      { find: /^geodesicd-client$/, replacement: here('../../js/src/index.ts') },
      { find: /^geodesicd-client\/three$/, replacement: here('../../js/src/three.ts') },
    ],
    dedupe: ['three'],
  },
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 900,
  },
  worker: { format: 'es' },
  server: { proxy: { '/v1': server, '/docs': server } },
  preview: { proxy: { '/v1': server, '/docs': server } },
});
