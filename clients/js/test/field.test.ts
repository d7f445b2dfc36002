/** The finished example of the README, in a real browser. */
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { noBrowser, openPage } from './browser_page.js';
import { Server } from './server.js';

test('the example uploads its geometry and colours it', { skip: noBrowser }, async () => {
  const server = await Server.start(['--cors-write-origins', '*']);
  after(() => server.stop());
  const found = (await openPage('/test/page/field_page.js', server.url)) as { error?: string; hues: number };
  assert.equal(found.error, undefined);
  assert.ok(found.hues > 12, `${found.hues} hues`);
});

test('where the server does not let it, the error says which flag would', { skip: noBrowser }, async () => {
  const server = await Server.start();
  after(() => server.stop());
  const found = (await openPage('/test/page/field_page.js', server.url)) as { error?: string };
  assert.match(found.error ?? '', /--cors-write-origins/);
});
