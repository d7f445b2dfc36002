// Links that somebody else has made: whatever they say, the page stays usable.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, openMesh, ready } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

for (const name of ['constructor', '__proto__', 'toString']) {
  test(`a kept path of the method ${name} is a method that the server does not have`, async () => {
    const page = await openMesh(browser, service, plane, `&kept=${name};1;0,0.3,0.3;9,0.3,0.3`);
    await page.locator('.trouble', { hasText: 'does not have this method' }).waitFor();
    assert.equal(await page.locator('.measures li').count(), 1);
    assert.deepEqual(page.faults.filter((text) => !/Failed to load resource.*(400|404|422)/.test(text)), []);
    await page.context().close();
  });
}

test('that WebGL 2 is missing is said where it is missing, and only there', async () => {
  const page = await newPage(browser);
  await page.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
  await page.goto(`${service.url}#mesh=${plane}`);
  await ready(page, 'failed');
  assert.match(await page.locator('.trouble').textContent(), /cannot draw here.*WebGL 2/);
  await page.context().close();
  const other = await newPage(browser);
  await other.addInitScript(() => { window.ResizeObserver = class { observe() { throw new Error('not today'); } }; });
  await other.goto(`${service.url}#mesh=${plane}`);
  await ready(other, 'failed');
  assert.match(await other.locator('.trouble').textContent(), /went wrong in this page.*not today/);
  await other.context().close();
});
