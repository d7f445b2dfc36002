// Lines that are drawn by clicks become walls and sources, where the server has these; undone, and in links.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, openMesh, pathLength, picture, ready, settled, textAt, until } from './browser.mjs';
import { shareOf } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const { limits: has } = await service.json('/v1/status');
const WALL = '#d8404a';
const CURVE = '#ff5d3b';

/**
 * A page on a server that has both, whatever the one of the test has: what that does not know is left out of the
 * questions, which `asked` has as they were; a curve is its points.
 */
async function onServerWithBoth(more = '') {
  const page = await newPage(browser);
  const asked = [];
  await page.route(/\/v1\/status/, async (route) => {
    const reply = await route.fetch();
    const status = await reply.json();
    Object.assign(status.limits, { max_walls: 100, max_curve_points: 1000 });
    await route.fulfill({ response: reply, json: status });
  });
  await page.route(/\/v1\/meshes\/\w+\/(distance|path|loop)\?/, async (route) => {
    const url = new URL(route.request().url());
    asked.push(decodeURIComponent(url.href));
    if (!('max_walls' in has)) url.searchParams.delete('walls');
    if ('max_curve_points' in has) return route.continue({ url: readable(url) });
    const from = url.searchParams.getAll('from').flatMap((text) => text.replace(/^curve:(closed;)?/, '').split(';'));
    url.searchParams.delete('from');
    const path = url.pathname.endsWith('path');
    for (const text of path ? from.slice(0, 1) : from) url.searchParams.append('from', text);
    return route.continue({ url: readable(url) });
  });
  await page.goto(`${service.url}#mesh=${plane}${more}`);
  await ready(page);
  return { page, asked };
}

const readable = ({ href }) => href.replaceAll('%3A', ':').replaceAll('%2C', ',').replaceAll('%3B', ';');

async function draw(page, ...places) {
  await page.getByLabel('Loop', { exact: true }).check();
  for (const place of places) await page.mouse.click(...place);
  await page.locator('.loop-part:not(.stale)').waitFor();
  await textAt(page, '#round', (text) => /\d/.test(text));
}

test('a drawn line becomes a wall in every question, and is undone', async () => {
  const { page, asked } = await onServerWithBoth();
  await page.mouse.click(250, 330);
  await page.mouse.click(620, 430);
  const straight = await pathLength(page);
  const bare = await settled(page);
  await draw(page, [430, 250], [450, 380], [430, 500]);
  await page.getByRole('button', { name: 'Make it a wall' }).click();
  const [, wall] = await until(async () => /[#&]wall=([^&]+)/.exec(page.url()), 'the wall in the link');
  const text = wall.split(';').map((spot) => `f:${spot}`).join(';');
  for (const query of ['distance', 'path']) {
    await until(async () => asked.some((url) => url.includes(`/${query}?`) && url.includes(`walls=${text}`)), query);
  }
  assert.equal(text.split(';').length, 3);
  if ('max_walls' in has) assert.ok(Number(await pathLength(page, straight)) > 1.01 * Number(straight), 'the path goes round it');
  const drawn = await picture(page, '100-wall');
  const without = shareOf(bare, WALL); // the source is of a like colour
  assert.ok(shareOf(drawn, WALL) > without + 0.0005, `it is drawn: ${shareOf(drawn, WALL)}`);
  await page.keyboard.press('Control+z');
  assert.equal(await page.locator('.point.wall').count(), 0);
  assert.equal(await page.locator('.loop-part h2').textContent(), 'Line');
  await page.keyboard.press('Control+Shift+z');
  await until(async () => page.url().includes('&wall='), 'again');
  await page.waitForTimeout(300);
  await page.reload();
  await ready(page);
  await until(async () => shareOf(await settled(page), WALL) > without + 0.0005, 'the wall of a link');
  await page.getByRole('button', { name: 'Remove Wall' }).click();
  await until(async () => !page.url().includes('wall='), 'it is gone');
  assert.ok(shareOf(await settled(page), WALL) < without + 0.0002);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('distances begin on a drawn line, closed or not, and paths lead there', async () => {
  const { page, asked } = await onServerWithBoth();
  await draw(page, [250, 250], [300, 400], [260, 500]);
  await page.getByRole('button', { name: 'Close the loop' }).click();
  await textAt(page, '.loop-part:not(.stale) h2', (text) => text === 'Loop through points');
  await page.getByRole('button', { name: 'Measure from it' }).click();
  await page.waitForSelector('.legend:not([hidden])');
  const distance = await until(async () => asked.find((url) => url.includes('/distance?')), 'the field');
  assert.match(distance, /from=curve:closed;f:[\d.,]+;f:[\d.,]+;f:[\d.,]+&/);
  assert.ok(await page.getByLabel('Cells').isDisabled());
  await page.getByLabel('Target', { exact: true }).check();
  await page.mouse.click(600, 300);
  await textAt(page, '#length', (text) => /\d/.test(text));
  assert.ok(asked.some((url) => /\/path\?from=curve:closed;/.test(url)));
  assert.equal(await page.getByRole('button', { name: 'Keep' }).isVisible(), false, 'what is kept begins at a point');
  await page.mouse.move(5, 5);
  assert.ok(shareOf(await picture(page, '101-curve'), CURVE) > 0.0005);
  for (const step of ['the target', 'the curve']) await page.keyboard.press('Control+z', step);
  assert.equal(await page.locator('.legend').isVisible(), false);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('what the server does not have has no button', async () => {
  const page = await openMesh(browser, service, plane);
  await draw(page, [250, 250], [300, 400]);
  assert.equal(await page.getByRole('button', { name: 'Make it a wall' }).isVisible(), 'max_walls' in has);
  assert.equal(await page.getByRole('button', { name: 'Measure from it' }).isVisible(), 'max_curve_points' in has);
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
