// Lines that are drawn by clicks become walls and sources, where the server has these; undone, and in links.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { openMesh, pageWithout, pathLength, picture, ready, reload, settled, textAt, until } from './browser.mjs';
import { shareOf } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const WALL = '#d8404a';
const CURVE = '#ff5d3b';

async function draw(page, ...places) {
  await page.getByLabel('Loop', { exact: true }).check();
  for (const place of places) await page.mouse.click(...place);
  await page.locator('.loop-part:not(.stale)').waitFor();
  await textAt(page, '#round', (text) => /\d/.test(text));
}

test('a drawn line becomes a wall in every question, and is undone', async () => {
  const page = await openMesh(browser, service, plane);
  const asked = () => page.asked.map(decodeURIComponent);
  await page.mouse.click(250, 330);
  await page.mouse.click(620, 430);
  const straight = await pathLength(page);
  const bare = await settled(page);
  await draw(page, [430, 250], [450, 380], [430, 500]);
  await page.getByRole('button', { name: 'Make it a wall' }).click();
  const [, wall] = await until(async () => /[#&]wall=([^&]+)/.exec(page.url()), 'the wall in the link');
  const text = wall.split(';').map((spot) => `f:${spot}`).join(';');
  for (const query of ['distance', 'path']) {
    await until(async () => asked().some((url) => url.includes(`/${query}?`) && url.includes(`walls=${text}`)), query);
  }
  assert.equal(text.split(';').length, 3);
  assert.ok(Number(await pathLength(page, straight)) > 1.01 * Number(straight), 'the path goes round it');
  const drawn = await picture(page, '100-wall');
  const without = shareOf(bare, WALL); // the source is of a like colour
  assert.ok(shareOf(drawn, WALL) > without + 0.0005, `it is drawn: ${shareOf(drawn, WALL)}`);
  await page.keyboard.press('Control+z');
  assert.equal(await page.locator('.point.wall').count(), 0);
  assert.equal(await page.locator('.loop-part h2').textContent(), 'Line');
  await page.keyboard.press('Control+Shift+z');
  await until(async () => page.url().includes('&wall='), 'again');
  await reload(page);
  await ready(page);
  await until(async () => shareOf(await settled(page), WALL) > without + 0.0005, 'the wall of a link');
  await page.getByRole('button', { name: 'Remove Wall' }).click();
  await until(async () => !page.url().includes('wall='), 'it is gone');
  assert.ok(shareOf(await settled(page), WALL) < without + 0.0002);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('distances begin on a drawn line, closed or not, and paths lead there', async () => {
  const page = await openMesh(browser, service, plane);
  const asked = () => page.asked.map(decodeURIComponent);
  await draw(page, [250, 250], [300, 400], [260, 500]);
  await page.getByRole('button', { name: 'Close the loop' }).click();
  await textAt(page, '.loop-part:not(.stale) h2', (text) => text === 'Loop through points');
  await page.getByRole('button', { name: 'Measure from it' }).click();
  await page.waitForSelector('.legend:not([hidden])');
  const distance = await until(async () => asked().find((url) => url.includes('/distance?')), 'the field');
  assert.match(distance, /from=curve:closed;f:[\d.,]+;f:[\d.,]+;f:[\d.,]+&/);
  assert.ok(await page.getByLabel('Cells').isDisabled());
  await page.getByLabel('Target', { exact: true }).check();
  await page.mouse.click(600, 300);
  await textAt(page, '#length', (text) => /\d/.test(text));
  assert.ok(asked().some((url) => /\/path\?from=curve:closed;/.test(url)));
  assert.equal(await page.getByRole('button', { name: 'Keep' }).isVisible(), false, 'what is kept begins at a point');
  await page.mouse.move(5, 5);
  assert.ok(shareOf(await picture(page, '101-curve'), CURVE) > 0.0005);
  for (const _ of ['the target', 'the curve']) await page.keyboard.press('Control+z');
  assert.equal(await page.locator('.legend').isVisible(), false);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('the file of a path from a line has the path that is seen', async () => {
  const page = await openMesh(browser, service, plane, '&curve=1200,0.3,0.3;1260,0.3,0.3&to=9700,0.3,0.3');
  await pathLength(page);
  await page.getByText('Export', { exact: true }).click();
  const saved = async (name) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name }).click()]);
    return readFile(await download.path());
  };
  const path = JSON.parse(await saved('Path · JSON'));
  assert.equal(path.from.kind, 'curve');
  assert.notDeepEqual(path.points[0].xyz, path.from.xyz, 'it begins at another place than the line');
  const glb = await saved('Path · GLB');
  const document = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)));
  assert.equal(document.accessors[document.meshes[0].primitives[0].attributes.POSITION].count, path.points.length);
  const asked = page.asked.map(decodeURIComponent).find((url) => url.includes('/path?') && url.includes('format=glb'));
  assert.match(asked, /[?&]from=curve:f:1200,0\.3,0\.3;f:1260,0\.3,0\.3&/);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('what an older server does not have has no button', async () => {
  const page = await pageWithout(browser, 'max_walls', 'max_curve_points');
  await page.goto(`${service.url}#mesh=${plane}`);
  await ready(page);
  await draw(page, [250, 250], [300, 400]);
  for (const name of ['Make it a wall', 'Measure from it']) {
    assert.equal(await page.getByRole('button', { name }).isVisible(), false, name);
  }
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('walls and curves that a link says wrongly are left out', async () => {
  const page = await openMesh(browser, service, plane, '&wall=5,0.3,0.3&curve=closed;5,0.3,0.3;6,0.3,0.3&wall=5,0.3,0.3;99999999,0.2,0.2');
  await page.locator('.trouble', { hasText: 'wall=99999999' }).waitFor();
  assert.equal(await page.locator('.point').count(), 0);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
