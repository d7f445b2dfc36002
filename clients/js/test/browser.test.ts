/**
 * The client in a real browser, on a page of another origin than the server: CORS, its
 * exposed headers, XMLHttpRequest and streams are the browser's own. Needs Chromium, as
 * `CHROMIUM` or in the PATH.
 */
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createServer } from 'node:http';
import type { AddressInfo } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { sample, Server } from './server.js';

const wanted = [process.env['CHROMIUM'], 'chromium', 'chromium-browser', 'google-chrome'];
const browser = wanted.find((name) => name && spawnSync(name, ['--version']).status === 0);

/** Serves the page with what it imports; resolves with what it found. */
async function serve(): Promise<{ url: string; found: Promise<unknown> }> {
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
      const html = '<!doctype html><script type="module" src="/test/page/page.js"></script>';
      reply.setHeader('Content-Type', 'text/html').end(html);
    } else if (/^\/(dist|test\/page)\/[\w/]+\.js$/.test(path)) {
      const script = readFileSync(new URL(path.slice(1), root));
      reply.setHeader('Content-Type', 'text/javascript').end(script);
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

test('a page of another origin', { skip: browser ? false : 'there is no Chromium' }, async () => {
  const server = await Server.start();
  after(() => server.stop());
  const { url, found } = await serve();
  const profile = mkdtempSync(join(tmpdir(), 'js_browser_'));
  const flags = ['--headless', '--no-sandbox', '--disable-gpu', `--user-data-dir=${profile}`];
  const child = spawn(
    browser!,
    [...flags, '--remote-debugging-port=0', `${url}?server=${encodeURIComponent(server.url)}`],
    { stdio: 'ignore' },
  );
  const over = once(child, 'exit');
  try {
    const early = over.then(() => assert.fail('the browser ended without a word'));
    early.catch(() => undefined);
    const size = sample('plane.glb').length;
    assert.deepEqual(await Promise.race([found, early]), {
      sent: [size, size],
      digestFirst: true,
      field: [10000, 99, 'miss', true],
      bare: ['<f4', [10000], true],
      job: [99, 'done'],
      abort: 'AbortError',
      cancelled: 'cancelled',
      batch: [9, 'index_out_of_range'],
      refused: ['format_unknown', true],
      nobody: true,
    });
  } finally {
    child.kill('SIGKILL');
    await over;
    rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
  }
});
