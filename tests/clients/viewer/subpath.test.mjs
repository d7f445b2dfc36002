// The page behind a proxy that has it under a path of its own.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drop, newPage, openMesh, pathLength, picture, ready, until } from './browser.mjs';
import { proxied } from './proxy.mjs';
import { served } from './served.mjs';
import { wavyMesh } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const proxy = await proxied(service);

test('under /geo/ the page draws, asks and uploads, and asks for nothing elsewhere', async () => {
  const page = await openMesh(browser, proxy, plane);
  await page.mouse.click(250, 330);
  await page.waitForSelector('.legend:not([hidden])');
  await page.mouse.click(620, 430);
  const length = await pathLength(page);
  await picture(page, '70-under-a-path');
  // A job, with its stream of events, and an export.
  await page.getByLabel('Chen–Han').check();
  await until(async () => /Chen–Han/.test(await page.textContent('.result')), 'the exact path');
  await page.getByText('Export', { exact: true }).click();
  const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Field · NPY' }).click()]);
  assert.equal(saved.suggestedFilename(), 'plane.field.npy');
  await drop(page, 'waves.glb', wavyMesh(30));
  await until(async () => (await page.locator('#mesh option:checked').textContent()) === 'waves.glb', 'the upload');
  await ready(page);
  assert.ok(Number(length) > 0);
  for (const url of page.asked) assert.ok(url.startsWith(proxy.url) || url.startsWith('blob:'), url);
  assert.deepEqual(proxy.lost, []);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a link from under /geo/ leads back there', async () => {
  const page = await openMesh(browser, proxy, plane, '&from=9700,0.3,0.3&to=19000,0.25,0.25');
  const length = await pathLength(page);
  await page.mouse.click(420, 180);
  await pathLength(page, length);
  await until(async () => page.url().includes('from='), 'the link');
  assert.ok(page.url().startsWith(`${proxy.url}#mesh=${plane}`), page.url());
  const other = await newPage(browser);
  await other.goto(page.url());
  await ready(other);
  await pathLength(other);
  assert.deepEqual([...page.faults, ...other.faults], []);
  await page.context().close();
  await other.context().close();
});

test('the guide is linked under the path: of the methods beside their list, all of it in the help', async () => {
  const page = await openMesh(browser, proxy, plane);
  const methods = page.getByRole('link', { name: 'All methods compared' });
  assert.equal(await methods.evaluate((link) => link.href), `${proxy.url}docs/methods/`);
  await page.keyboard.press('?');
  assert.equal(await page.getByRole('link', { name: 'The guide' }).evaluate((link) => link.href), `${proxy.url}docs/`);
  await page.context().close();
});

test('without scripts the page says where the API is described, under its path', async () => {
  const html = await (await fetch(proxy.url)).text();
  const [, href] = /<noscript>.*?href="([^"]+)"/s.exec(html);
  const reply = await fetch(new URL(href, proxy.url));
  assert.equal(reply.status, 200);
  assert.match(reply.headers.get('Content-Type'), /text\/html/);
});
