// Links that somebody else has made: whatever they say, the page stays usable.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, openMesh, pathLength, ready } from './browser.mjs';
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

test('a link is followed although the page writes its own in the same moment', async () => {
  const page = await openMesh(browser, service, plane);
  await page.evaluate(() => {
    const own = location.hash;
    location.hash = '#mesh=no-such-name';
    history.replaceState(null, '', own); // before the page is told of the other one
  });
  await page.locator('.trouble', { hasText: 'No mesh has this name' }).waitFor();
  await page.context().close();
});

test('a link asks for no more than the page itself would', async () => {
  const many = (count, text) => Array.from({ length: count }, (_, at) => text(at)).join('');
  const page = await openMesh(browser, service, plane, [
    '&from=5,0.3,0.3&to=9,0.3,0.3&arrow=5,0.3,0.3;1,0,0;Infinity&method=steiner&points_per_edge=1.5',
    many(60, (at) => `&kept=auto;0;${at},0.3,0.3;${at + 20},0.3,0.3`),
    many(101, (at) => `&via=${at},0.3,0.3`),
  ].join(''));
  await pathLength(page);
  assert.equal(await page.locator('.measures li').count(), 50);
  // One source, a hundred via points and a target; no arrow without an end.
  assert.equal(await page.locator('.points .point').count(), 102);
  assert.ok(page.asked.every((url) => !/points_per_edge/.test(url)));
  assert.deepEqual(await page.locator('.trouble').allTextContents(), []);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a limit of points is said in points, one of a body in bytes', async () => {
  for (const [parameter, text] of [['from', 'limit 1,000, here 3,000'], [undefined, 'limit 1 kB, here 3 kB']]) {
    const page = await openMesh(browser, service, plane);
    const body = JSON.stringify({ code: 'too_large', detail: 'too many', parameter, limit: 1000, actual: 3000 });
    await page.route(/\/distance/, (route) => route.fulfill({ status: 413, contentType: 'application/problem+json', body }));
    await page.locator('#vertex').fill('0');
    await page.keyboard.press('Enter');
    await page.locator('.trouble', { hasText: text }).waitFor();
    await page.context().close();
  }
});
