// What is kept beside the points: measures with all that their length depends on, steps to be
// undone, names, jobs of the server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, pathLength, ready, reload, textAt, until } from './browser.mjs';
import { served } from './served.mjs';
import { wavyMesh } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

test('a kept path of the method steiner has its points per edge in the link', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&to=1234,0.25,0.25&method=steiner&points_per_edge=1&refine=none');
  const length = await pathLength(page);
  await page.getByRole('button', { name: 'Keep' }).click();
  await page.locator('#per-edge').evaluate((slider) => {
    slider.value = '12';
    slider.dispatchEvent(new Event('change'));
  });
  const finer = await pathLength(page, length);
  await until(() => /kept=steiner-1;/.test(page.url()) && /points_per_edge=12/.test(page.url()), 'both in the link');
  await reload(page);
  await ready(page);
  assert.equal(await pathLength(page), finer);
  assert.equal(await textAt(page, '.measures .number', (text) => /\d/.test(text)), length);
  // To show it again brings them back, too.
  await page.locator('.measures .measure').click();
  assert.equal(await pathLength(page, finer), length);
  assert.equal(await page.locator('#per-edge').inputValue(), '1');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('of two sources in one face, that is kept which the path begins at', async () => {
  const target = '1234,0.25,0.25';
  const sources = ['9700,0.8,0.1', '9700,0.1,0.8'];
  const asked = sources.map((from) => service.json(`/v1/meshes/${plane}/path?from=f:${from}&to=f:${target}`));
  const [one, other] = (await Promise.all(asked)).map(({ length }) => length);
  assert.ok(Math.abs(one - other) > 0.1, 'they are not equally far');
  const nearest = sources[one < other ? 0 : 1];
  for (const order of [sources, [...sources].reverse()]) {
    const page = await openMesh(browser, service, plane, `&from=${order[0]}&from=${order[1]}&to=${target}`);
    const length = await pathLength(page);
    await page.getByRole('button', { name: 'Keep' }).click();
    const [, kept] = await until(() => /&kept=([^&]+)/.exec(decodeURIComponent(page.url())), 'the measure in the link');
    assert.equal(kept.split(';')[2], nearest);
    await reload(page);
    await ready(page);
    assert.equal(await textAt(page, '.measures .number', (text) => /\d/.test(text)), length);
    assert.deepEqual(page.faults, []);
    await page.context().close();
  }
});

test('a kept path is shown again without the line that is a source now', async () => {
  const more = '&curve=1200,0.3,0.3;1260,0.3,0.3&to=5000,0.25,0.25&kept=auto;1;9700,0.3,0.3;5000,0.25,0.25';
  const page = await openMesh(browser, service, plane, more);
  const fromLine = await pathLength(page);
  const length = await textAt(page, '.measures .number', (text) => /\d/.test(text));
  assert.ok(Number(fromLine) < Number(length), 'the line is nearer');
  await page.locator('.measures .measure').click();
  assert.equal(await pathLength(page, fromLine), length);
  await until(() => !page.url().includes('curve='), 'the link without the line');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('with a question open, nothing behind it is undone', async () => {
  const page = await openMesh(browser, service, plane);
  const points = page.locator('.points .point');
  await page.locator('#vertex').fill('0');
  await page.keyboard.press('Enter');
  await points.waitFor();
  await page.locator('button[aria-label="Delete this mesh"]').click();
  await page.locator('dialog[open]').waitFor();
  await page.keyboard.press('Control+z');
  assert.equal(await points.count(), 1);
  await page.keyboard.press('Escape');
  await page.keyboard.press('Control+z');
  await until(async () => (await points.count()) === 0, 'the step back');
  await page.context().close();
});

test('a name that is too long in bytes stays in its line, and the question says why', async () => {
  const page = await openMesh(browser, service, plane);
  await page.locator('button[aria-label="Rename this mesh"]').click();
  const line = page.locator('dialog[open] input');
  await line.fill('😀'.repeat(100));
  await page.keyboard.press('Enter');
  assert.match(await line.evaluate((input) => input.validationMessage), /at most 200 bytes, and this one 400/);
  assert.equal(await line.inputValue(), '😀'.repeat(100));
  const renamed = page.waitForResponse((response) => response.request().method() === 'PATCH');
  await line.fill('😀'.repeat(50));
  await page.keyboard.press('Enter');
  assert.equal((await renamed).status(), 200);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a job that was cancelled is not cancelled again when the page goes', async () => {
  const { id } = await service.json('/v1/meshes', { method: 'POST', body: wavyMesh(420) });
  const page = await openMesh(browser, service, id, '&from=90000,0.3,0.3&method=chen_han');
  const deleted = [];
  page.on('request', (request) => { if (request.method() === 'DELETE') deleted.push(request); });
  const gone = () => page.evaluate(() => dispatchEvent(new PageTransitionEvent('pagehide')));
  await page.locator('.work').getByRole('button', { name: 'Cancel' }).click();
  await until(() => deleted.length, 'the end of the job');
  await (await deleted[0].response()).finished();
  await until(async () => (await page.locator('.work').count()) === 0, 'the work is gone from the page');
  await gone();
  // What is asked later goes out later.
  await page.evaluate(() => fetch('v1/status'));
  assert.equal(deleted.length, 1);
  await page.context().close();
});
