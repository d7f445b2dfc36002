// Files of sources that are larger than any list of sources.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

test('a file that is too large for sources is refused before it is read', async () => {
  const page = await openMesh(browser, service, plane);
  await page.evaluate(() => {
    window.reads = 0;
    Blob.prototype.text = () => { window.reads++; return Promise.resolve('1'); };
  });
  const file = { name: 'cloud.txt', mimeType: 'text/plain', buffer: Buffer.alloc(6_000_000, '1 2 3\n') };
  await page.setInputFiles('input[aria-label="File of sources"]', file);
  await page.locator('.trouble', { hasText: /too large for a list of sources.*5\.0 MB.*cloud\.txt: 6\.0 MB/ }).waitFor();
  assert.equal(await page.evaluate(() => window.reads), 0);
  // A smaller one is read.
  await page.setInputFiles('input[aria-label="File of sources"]', { ...file, buffer: Buffer.from('1\n') });
  await page.locator('.points .point').waitFor();
  assert.equal(await page.evaluate(() => window.reads), 1);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
