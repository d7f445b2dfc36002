// Ways that are quick on foot, where the server knows of slopes; and that nothing of it is shown where it does not.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, newPage, pathLength, picture, ready, textAt, until } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const terrain = await service.sample('terrain');
const POINTS = '&from=2000,0.3,0.3&to=60000,0.3,0.3';

test('distances are seconds on foot, by the axis that is up, and lengths again when it is undone', async () => {
  const page = await openMesh(browser, service, terrain, `${POINTS}&up=y`);
  const short = await pathLength(page);
  assert.equal(await page.textContent('.legend h2'), 'Distance');
  await page.getByLabel('Quickest on foot').check();
  await textAt(page, '.legend h2', (text) => text === 'Seconds on foot');
  for (const query of ['distance', 'path']) {
    await until(async () => page.asked.some((url) => new RegExp(`/${query}\\?.*method=steiner&slope=tobler&up=0,1,0`).test(decodeURIComponent(url))), query);
  }
  assert.ok(page.asked.every((url) => !url.includes('slope') || !url.includes('refine=shortest')));
  await until(async () => Number((await page.textContent('#length')).replaceAll(',', '')) > Number(short), 'a longer way');
  await textAt(page, '.result .facts', (text) => /^[\d.,]+ (s|min) on foot · Steiner/.test(text));
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

test('what an older server does not know of is not shown', async () => {
  const page = await newPage(browser);
  await page.route(/\/v1\/status/, async (route) => {
    const reply = await route.fetch();
    const status = await reply.json();
    delete status.limits.max_slopes;
    await route.fulfill({ response: reply, json: status });
  });
  await page.goto(`${service.url}#mesh=${terrain}${POINTS}`);
  await ready(page);
  await pathLength(page);
  assert.equal(await page.getByLabel('Quickest on foot').isVisible(), false);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
