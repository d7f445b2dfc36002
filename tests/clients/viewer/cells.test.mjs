// Cells of the nearest source: their borders and areas, sources into their middles, and back.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, picture, settled, textAt, until } from './browser.mjs';
import { difference } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const PLACES = [[250, 250], [290, 260], [270, 300], [560, 500]];

const areas = async (page) => (await page.locator('.areas .area').allTextContents()).map((text) => Number(text.replaceAll(',', '')));

async function withSources(page) {
  await page.mouse.click(...PLACES[0]);
  await page.getByLabel('Add', { exact: true }).check();
  for (const place of PLACES.slice(1)) await page.mouse.click(...place);
}

test('cells have their borders on the mesh and their areas beside it, and are relaxed and undone', async () => {
  const page = await openMesh(browser, service, plane);
  assert.ok(await page.getByLabel('Cells').isDisabled(), 'cells need two sources');
  await withSources(page);
  await page.getByLabel('Regions').check();
  await textAt(page, '.legend h2', (text) => text === 'Nearest source');
  const regions = await settled(page);
  assert.ok(page.asked.every((url) => !url.includes('/voronoi')), 'nobody asked for cells');
  await page.getByLabel('Cells').check();
  await until(async () => (await areas(page)).length === 4, 'the areas');
  const before = await areas(page);
  const bordered = await picture(page, '98-cells');
  const apart = difference(regions, bordered);
  assert.ok(apart > 0.0005 && apart < 0.1, `borders and labels: ${apart}`);
  // The areas of the server, on a plane of 99 by 99.
  const from = [...(await until(async () => page.url().includes('show=cells') && page.url(), 'the link')).matchAll(/from=([\d.,]+)/g)].map(([, spot]) => `from=f:${spot}`);
  const { cells } = await service.json(`/v1/meshes/${plane}/voronoi?${from.join('&')}&method=auto`);
  assert.deepEqual(before, cells.map(({ area }) => Number(area.toPrecision(4))));
  assert.ok(Math.abs(before.reduce((sum, area) => sum + area) - 9801) < 10);
  assert.match(await page.textContent('.cells-part'), /4 cells with 9,801 m² in all/);
  await page.getByRole('button', { name: 'Relax' }).click();
  await until(async () => (await areas(page)).length === 4 && String(await areas(page)) !== String(before), 'other areas');
  const after = await areas(page);
  assert.ok(Math.max(...after) / Math.min(...after) < Math.max(...before) / Math.min(...before), `${before}, ${after}`);
  assert.ok(page.asked.some((url) => /voronoi\?.*relax=5/.test(url)));
  await picture(page, '99-cells-relaxed');
  await page.getByText('Export', { exact: true }).click();
  const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Cells · GLB' }).click()]);
  assert.equal(saved.suggestedFilename(), 'plane.cells.glb');
  await page.getByRole('button', { name: 'Undo' }).click();
  await until(async () => String(await areas(page)) === String(before), 'as before');
  await page.keyboard.press('Control+Shift+z');
  await until(async () => String(await areas(page)) === String(after), 'relaxed again');
  // A source that is taken away takes its cell along, and the last but one all of them.
  await page.getByRole('button', { name: 'Remove Source 4' }).click();
  await until(async () => (await areas(page)).length === 3, 'three cells');
  for (const left of [2, 1]) await page.getByRole('button', { name: `Remove Source ${left + 1}` }).click();
  await until(async () => !(await page.locator('.cells-part').isVisible()), 'no cells');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a refusal is told, and the next answer takes it away', async () => {
  const page = await openMesh(browser, service, plane, '&from=5,0.3,0.3&from=9000,0.3,0.3');
  const body = JSON.stringify({ code: 'too_much_memory', detail: 'cells of many sites' });
  await page.route(/\/voronoi/, (route) => route.fulfill({ status: 422, contentType: 'application/problem+json', body }));
  await page.getByLabel('Cells').check();
  await page.locator('.trouble', { hasText: 'more memory' }).waitFor();
  assert.ok(await page.getByRole('button', { name: 'Relax' }).isDisabled());
  await page.unroute(/\/voronoi/);
  await page.getByLabel('Add', { exact: true }).check();
  await page.mouse.click(500, 300);
  await until(async () => (await areas(page)).length === 3, 'the areas');
  assert.equal(await page.locator('.trouble').count(), 0);
  await page.context().close();
});
