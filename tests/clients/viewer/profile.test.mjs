// The profile of a path: height against distance, with a dot on the mesh where one points.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, pathLength, picture, settled, textAt, until } from './browser.mjs';
import { difference } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const terrain = await service.sample('terrain');

test('pointing at the chart shows a dot on the mesh, and pointing at the path one on the chart', async () => {
  const page = await openMesh(browser, service, terrain, '&from=2000,0.3,0.3&to=60000,0.3,0.3');
  const length = Number(await pathLength(page));
  await page.getByText('Profile', { exact: true }).click();
  const chart = page.locator('.profile');
  const said = await until(async () => chart.getAttribute('aria-label'), 'the chart');
  // The same heights as the server's.
  const path = await service.json(`/v1/meshes/${terrain}/path?from=f:2000,0.3,0.3&to=f:60000,0.3,0.3&method=auto&refine=shortest`);
  const heights = path.points.map(({ xyz }) => xyz[1]);
  const [, low, high] = /from (-?[\d.]+) to (-?[\d.]+)$/.exec(said);
  const range = Math.max(...heights) - Math.min(...heights);
  assert.ok(Math.abs(low - Math.min(...heights)) < 0.02 * range && Math.abs(high - Math.max(...heights)) < 0.02 * range, said);
  const bare = await settled(page);
  const box = await chart.boundingBox();
  await page.mouse.move(box.x + box.width * (44 + 74) / 284, box.y + 50);
  const told = await textAt(page, '#along', (text) => text.includes('along'));
  const along = Number(told.split(' ')[0]);
  assert.ok(Math.abs(along / length - 0.32) < 0.02, told);
  const dotted = await picture(page, '70-profile');
  const apart = difference(bare, dotted);
  assert.ok(apart > 0.0001 && apart < 0.01, `a dot on the mesh: ${apart}`);
  await page.mouse.move(30, 30);
  await textAt(page, '#along', (text) => !text.includes('along'));
  // On the mesh: the first label of the path's distances stands above the path.
  const label = await page.locator('.labels span').nth(0).boundingBox();
  const wanted = Number((await page.locator('.labels span').nth(0).textContent()).replaceAll(',', ''));
  await page.mouse.move(label.x + label.width / 2, label.y + label.height * 1.6);
  const there = await textAt(page, '#along', (text) => text.includes('along'));
  assert.ok(Math.abs(Number(there.split(' ')[0]) / wanted - 1) < 0.15, `${there}, not ${wanted}`);
  // With keys.
  await page.getByLabel('Place along the path').focus();
  await page.keyboard.press('End');
  await textAt(page, '#along', (text) => Math.abs(Number(text.split(' ')[0]) / length - 1) < 0.01);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
