// Ways that are quick on foot, where the server knows of slopes; and that nothing of it is shown where it does not.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, newPage, pathLength, picture, ready, textAt, until } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const { limits: has } = await service.json('/v1/status');
const terrain = await service.sample('terrain');
const POINTS = '&from=2000,0.3,0.3&to=60000,0.3,0.3';

test('distances are seconds on foot, by the axis that is up, and lengths again when it is undone', async () => {
  const page = await newPage(browser);
  const asked = [];
  await page.route(/\/v1\/status/, async (route) => {
    const reply = await route.fetch();
    const status = await reply.json();
    status.limits.max_slopes = 1000;
    await route.fulfill({ response: reply, json: status });
  });
  await page.route(/\/v1\/meshes\/\w+\/(distance|path)\?/, (route) => {
    const url = new URL(route.request().url());
    asked.push(decodeURIComponent(url.href));
    if (!('max_slopes' in has)) for (const name of ['slope', 'up']) url.searchParams.delete(name);
    return route.continue({ url: url.href.replaceAll('%3A', ':').replaceAll('%2C', ',') });
  });
  await page.goto(`${service.url}#mesh=${terrain}${POINTS}&up=y`);
  await ready(page);
  const short = await pathLength(page);
  assert.equal(await page.textContent('.legend h2'), 'Distance');
  await page.getByLabel('Quickest on foot').check();
  await textAt(page, '.legend h2', (text) => text === 'Seconds on foot');
  for (const query of ['distance', 'path']) {
    await until(async () => asked.some((url) => new RegExp(`/${query}\\?.*method=steiner&slope=tobler&up=0,1,0`).test(url)), query);
  }
  assert.ok(asked.every((url) => !url.includes('slope') || !url.includes('refine=shortest')));
  await until(async () => Number((await page.textContent('#length')).replaceAll(',', '')) > Number(short), 'a longer way');
  if ('max_slopes' in has) await textAt(page, '.result .facts', (text) => /^[\d.,]+ (s|min) on foot · Steiner/.test(text));
  assert.ok(await page.getByLabel('Exact', { exact: false }).first().isDisabled());
  assert.equal(await page.getByLabel('Area within a radius').isVisible(), false);
  assert.equal(await page.getByRole('button', { name: 'Keep' }).isVisible(), false);
  await picture(page, '103-on-foot');
  await until(async () => page.url().includes('walking=y'), 'the link');
  await page.keyboard.press('Control+z');
  await textAt(page, '.legend h2', (text) => text === 'Distance');
  await textAt(page, '#length', (text) => text === short);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('what the server does not know of is not shown', async () => {
  const page = await openMesh(browser, service, terrain, POINTS);
  await pathLength(page);
  assert.equal(await page.getByLabel('Quickest on foot').isVisible(), 'max_slopes' in has);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
