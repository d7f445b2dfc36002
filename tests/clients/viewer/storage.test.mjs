// What the page remembers where the browser keeps nothing for it: storage that is forbidden
// or full, and a token that no header can carry.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, ready, until } from './browser.mjs';
import { served } from './served.mjs';
import { wavyObj } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

const theme = (page) => page.evaluate(() => document.documentElement.dataset.theme);

/** A page on a mesh, with something done in it before its own scripts run. */
async function opened(mesh, before) {
  const page = await newPage(browser);
  await page.addInitScript(before);
  await page.goto(`${service.url}#mesh=${mesh}`);
  return page;
}

test('forbidden storage costs nothing but the memory', async () => {
  const page = await opened(plane, () => {
    for (const name of ['localStorage', 'sessionStorage']) {
      Object.defineProperty(window, name, { get() { throw new DOMException('The operation is insecure.', 'SecurityError'); } });
    }
  });
  await ready(page);
  const was = await theme(page);
  await page.keyboard.press('t');
  assert.notEqual(await theme(page), was);
  await page.keyboard.press('t');
  assert.equal(await theme(page), was);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('full storage leaves the controls as they are', async () => {
  const { id } = await service.json('/v1/meshes?name=waves.obj', { method: 'POST', body: wavyObj(20) });
  const page = await opened(id, () => {
    Storage.prototype.setItem = () => { throw new DOMException('full', 'QuotaExceededError'); };
  });
  await ready(page);
  const was = await theme(page);
  await page.keyboard.press('t');
  assert.notEqual(await theme(page), was);
  const axis = () => /up=(.)/.exec(page.url())?.[1];
  const up = await until(axis, 'the axis in the link');
  await page.keyboard.press('u');
  await until(() => axis() !== up, 'another axis in the link');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a kept token that no header can carry is forgotten', async () => {
  const page = await opened(plane, () => sessionStorage.setItem('geodesicd-token', 'abc\u200b'));
  await ready(page);
  assert.equal(await page.evaluate(() => sessionStorage.getItem('geodesicd-token')), null);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('such a token is not taken, and the question says why', async () => {
  const page = await newPage(browser);
  const sent = [];
  await page.route(/\/v1\/methods$/, (route) => {
    const { authorization } = route.request().headers();
    sent.push(authorization);
    if (authorization) return route.continue();
    return route.fulfill({ status: 401, contentType: 'application/problem+json', body: JSON.stringify({ code: 'unauthorized', detail: 'a token is needed' }) });
  });
  await page.goto(`${service.url}#mesh=${plane}`);
  await page.getByRole('button', { name: 'Enter a token' }).click();
  const line = page.locator('dialog input');
  for (const wrong of ['abc\u200b', 'näme', 'two words']) {
    await line.fill(wrong);
    await page.keyboard.press('Enter');
    assert.match(await line.evaluate((input) => input.validationMessage), /Copy it again/);
    assert.ok(await line.isVisible(), 'the question stays open');
  }
  await line.fill(' sesame ');
  await page.keyboard.press('Enter');
  await until(() => sent.at(-1) === 'Bearer sesame', 'the request with the token');
  await page.context().close();
});
