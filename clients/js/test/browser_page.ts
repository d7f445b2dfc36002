/**
 * A page of a test in a real browser: served here, on another origin than geodesicd, with
 * what it imports, and opened in a headless Chromium (`CHROMIUM`, or in the PATH). A page
 * sends what it found to /found.
 */
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync } from 'node:fs';
import { rm } from 'node:fs/promises';
import { createServer } from 'node:http';
import type { AddressInfo } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after } from 'node:test';
import { sample } from './server.js';

const wanted = [process.env['CHROMIUM'], 'chromium', 'chromium-browser', 'google-chrome'];
const browser = wanted.find((name) => name && spawnSync(name, ['--version']).status === 0);

/** Why tests in a browser are skipped; false if they are not. */
export const noBrowser = browser ? false : 'there is no Chromium';

// As clients/js/examples/brush.html has them.
const imports = {
  three: '/node_modules/three/build/three.module.js',
  'geodesicd-client': '/dist/index.js',
  'geodesicd-client/three': '/dist/three.js',
};

/** Serves the page whose script is at `script`; resolves with what it found. */
async function serve(script: string): Promise<{ url: string; found: Promise<unknown> }> {
  let tell: (found: unknown) => void;
  const found = new Promise((resolve) => (tell = resolve));
  const root = new URL('../', import.meta.url);
  const page = createServer(async (request, reply) => {
    const path = new URL(request.url ?? '/', 'http://page').pathname;
    if (path === '/found') {
      let text = '';
      for await (const chunk of request.setEncoding('utf8')) text += chunk;
      reply.end();
      tell(JSON.parse(text));
    } else if (path === '/mesh.glb') {
      reply.end(sample('plane.glb'));
    } else if (path === '/') {
      const html =
        `<!doctype html><script type="importmap">${JSON.stringify({ imports })}</script>` +
        `<body><script type="module" src="${script}"></script>`;
      reply.setHeader('Content-Type', 'text/html').end(html);
    } else if (/^\/(dist|examples|test\/page|node_modules\/three\/build)\/[\w./]+\.js$/.test(path)) {
      const bytes = readFileSync(new URL(path.slice(1), root));
      reply.setHeader('Content-Type', 'text/javascript').end(bytes);
    } else {
      reply.writeHead(404).end();
    }
  });
  page.listen(0, '127.0.0.1');
  await once(page, 'listening');
  after(() => {
    page.close();
    page.closeAllConnections();
  });
  return { url: `http://127.0.0.1:${(page.address() as AddressInfo).port}/`, found };
}

/** Opens the page of that script with `?server=`; what it found. */
export async function openPage(script: string, server: string): Promise<unknown> {
  const { url, found } = await serve(script);
  const profile = mkdtempSync(join(tmpdir(), 'js_browser_'));
  const flags = ['--headless', '--no-sandbox', `--user-data-dir=${profile}`];
  const drawing = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
  const child = spawn(
    browser!,
    [...flags, ...drawing, '--remote-debugging-port=0', `${url}?server=${encodeURIComponent(server)}`],
    { stdio: 'ignore', detached: true }, // a group, with the processes it starts
  );
  const over = once(child, 'exit');
  try {
    const early = over.then(() => assert.fail('the browser ended without a word'));
    early.catch(() => undefined);
    return await Promise.race([found, early]);
  } finally {
    if (child.exitCode === null) process.kill(-child.pid!, 'SIGKILL');
    await over;
    // What was killed may still be writing for a moment.
    await rm(profile, { recursive: true, force: true, maxRetries: 50, retryDelay: 100 });
  }
}
