/**
 * The client in a real browser, on a page of another origin than the server: CORS, its
 * exposed headers, XMLHttpRequest and streams are the browser's own.
 */
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { noBrowser, openPage } from './browser_page.js';
import { sample, Server } from './server.js';

test('a page of another origin', { skip: noBrowser }, async () => {
  const server = await Server.start(['--cors-write-origins', '*']);
  after(() => server.stop());
  const size = sample('plane.glb').length;
  assert.deepEqual(await openPage('/test/page/page.js', server.url), {
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
});
