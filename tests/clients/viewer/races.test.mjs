// Answers that come late, come out of order or do not come: what is seen is always that of the
// present mesh and points.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, openMesh, pathLength, ready, textAt, until } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const hole = await service.sample('plane_one_hole');
const points = (page) => page.locator('.point').count();
const isStale = (page) => page.locator('.result.stale').count().then((count) => count > 0);

/** Holds back what fits until `release`; then `act` decides. `waiting` are those that are held. */
async function hold(page, pattern, act = (route) => route.continue()) {
  const waiting = [];
  let open = false;
  const handler = async (route) => {
    if (!open) await new Promise((go) => waiting.push(go));
    await act(route).catch(() => undefined); // it was cancelled meanwhile
  };
  await page.route(pattern, handler);
  return {
    waiting,
    release: () => {
      open = true;
      waiting.splice(0).forEach((go) => go());
    },
    end: () => page.unroute(pattern, handler),
  };
}

const problem = (status, code) => (route) =>
  route.fulfill({ status, contentType: 'application/problem+json', body: JSON.stringify({ code, status, title: code, detail: 'made up' }) });

async function place(page, text) {
  await page.locator('#vertex').fill(text);
  await page.keyboard.press('Enter');
}

for (const [how, answer, leave] of [
  ['is cancelled', undefined, (page) => page.locator('.work .cancel').click()],
  ['is not there', problem(404, 'mesh_unknown'), (_, held) => held.release()],
]) {
  test(`a mesh that ${how} leaves the one before, with its points`, async () => {
    const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&to=19000,0.25,0.25');
    const length = await pathLength(page);
    const held = await hold(page, '**/geometry**', answer);
    await page.selectOption('#mesh', hole);
    await until(() => held.waiting.length > 0, 'the question for the mesh');
    // What is still drawn is not the chosen mesh: no point is placed on it.
    await page.mouse.click(430, 340);
    assert.equal(await points(page), 0);
    page.asked.length = 0;
    await leave(page, held);
    await until(async () => (await page.locator('#mesh').inputValue()) === plane, 'the mesh before is chosen again');
    assert.equal(await pathLength(page), length);
    await page.waitForSelector('.legend:not([hidden])');
    assert.equal(await points(page), 2);
    assert.match(await page.title(), /^plane\.glb ·/);
    if (answer) assert.match(await page.locator('.trouble').textContent(), /not on the server/);
    await page.keyboard.press('3');
    await page.mouse.click(330, 250);
    await until(async () => page.url().includes(`mesh=${plane}`) && !(await isStale(page)) && (await page.textContent('#length')) !== length, 'the path on it');
    assert.deepEqual(page.asked.filter((url) => url.includes(hole) && !url.includes('geometry')), [], 'nothing is asked of the other');
    await page.context().close();
  });
}

test('a mesh on its way does not take the place of one that is chosen again', async () => {
  const page = await openMesh(browser, service, plane);
  const held = await hold(page, '**/geometry**');
  await page.selectOption('#mesh', hole);
  await until(() => held.waiting.length > 0, 'the question for the mesh');
  await page.selectOption('#mesh', plane);
  await ready(page);
  const gone = page.waitForEvent('requestfinished', (request) => request.url().includes(`${hole}/geometry`)).catch(() => undefined);
  const cancelled = page.waitForEvent('requestfailed', (request) => request.url().includes(`${hole}/geometry`)).catch(() => undefined);
  held.release();
  await Promise.race([gone, cancelled]);
  await page.mouse.click(430, 340);
  await page.waitForSelector('.legend:not([hidden])');
  assert.match(await page.title(), /^plane\.glb ·/);
  await page.context().close();
});
