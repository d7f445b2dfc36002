// Back and Forward of the browser: from mesh to mesh, never into a trap, never out of the page too soon.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, openMesh, pathLength, ready, until } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const [plane, sphere, saddle] = await Promise.all(['plane', 'sphere', 'saddle'].map((name) => service.sample(name)));

async function choose(page, mesh) {
  await page.locator('#mesh').selectOption(mesh);
  await shows(page, mesh);
}

/** Waits until a mesh is drawn and the address bar says so. */
async function shows(page, mesh) {
  await until(async () => (await page.locator('#mesh').inputValue()) === mesh && page.url().includes(mesh), 'the mesh');
  await ready(page);
}

test('Back leads to the mesh before, with its points, and Forward to the next one with its own', async () => {
  const page = await openMesh(browser, service, plane, '&from=100,0.3,0.3&to=9000,0.3,0.3');
  const onPlane = await pathLength(page);
  const steps = await page.evaluate(() => history.length);
  await choose(page, sphere);
  await page.locator('#vertex').fill('0');
  await page.keyboard.press('Enter');
  await until(async () => /from=/.test(page.url()), 'a source in the link');
  await choose(page, saddle);
  assert.equal(await page.evaluate(() => history.length), steps + 2, 'a step a mesh, and none for points');
  await page.goBack();
  await shows(page, sphere);
  assert.equal(await page.locator('.points .point').count(), 1);
  await page.goBack();
  await shows(page, plane);
  assert.equal(await pathLength(page), onPlane);
  await page.goForward();
  await shows(page, sphere);
  assert.equal(await page.locator('.points .point').count(), 1);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('Back to a mesh that is gone shows what is there, and leads further at the next press', async () => {
  const page = await newPage(browser);
  await page.route(/geometry/, (route) => route.continue()); // not out of the browser's cache
  await page.goto(`${service.url}docs/`);
  await page.goto(`${service.url}#mesh=${plane}`);
  await ready(page);
  const body = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n';
  const { id } = await service.json('/v1/meshes?name=short-lived', { method: 'POST', body, headers: { 'Content-Type': 'model/obj' } });
  await page.goto(`${service.url}#mesh=${id}`);
  await shows(page, id);
  await choose(page, saddle);
  await fetch(new URL(`/v1/meshes/${id}`, service.url), { method: 'DELETE' });
  await page.goBack();
  await page.locator('.trouble', { hasText: 'not on the server' }).waitFor();
  await shows(page, saddle);
  await page.goBack();
  await shows(page, plane);
  await page.goBack();
  await until(async () => page.url().includes('/docs/'), 'the page before');
  await page.context().close();
});

test('a mesh that is deleted here is no step to go back to', async () => {
  const page = await openMesh(browser, service, plane);
  const body = 'v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n';
  const { id } = await service.json('/v1/meshes?name=deleted-here', { method: 'POST', body, headers: { 'Content-Type': 'model/obj' } });
  await page.goto(`${service.url}#mesh=${id}`);
  await shows(page, id);
  await page.getByRole('button', { name: 'Delete' }).first().click();
  await page.locator('dialog[open]').getByRole('button', { name: 'Delete' }).click();
  await until(async () => ![id, ''].includes(await page.locator('#mesh').inputValue()), 'another mesh');
  await ready(page);
  await page.goBack();
  await shows(page, plane);
  assert.deepEqual(await page.locator('.trouble').allTextContents(), []);
  await page.context().close();
});

test('a mesh that is on its way is no step yet', async () => {
  const page = await openMesh(browser, service, plane);
  await choose(page, sphere);
  await page.route(new RegExp(`${saddle}/geometry`), () => undefined); // never answered
  await page.locator('#mesh').selectOption(saddle);
  await page.getByText('Fetching the mesh').waitFor();
  await page.goBack();
  await shows(page, plane);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
