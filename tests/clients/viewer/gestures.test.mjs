// What a reader does with the mouse and the keys, in the order in which one does it: a
// first picture, a source, a target that is dragged, methods, regions, an arrow, measures.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MESH, newPage, openMesh, pathLength, picture, ready, settled, textAt, until } from './browser.mjs';
import { difference, shareOf, statistics } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const knot = await service.sample('torus_knot');
const plane = await service.sample('plane');

// Seen straight on, the plane fills the middle of the view.
const LEFT = [250, 330];
const RIGHT = [620, 430];
// On the knot as it is seen at first.
const KNOT = [392, 314];

async function drag(page, [x, y], [toX, toY], steps = 20) {
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(toX, toY, { steps });
  await page.mouse.up();
}

test('a sample is drawn at once, in clay, and a hint says what to do', async () => {
  const page = await newPage(browser);
  await page.goto(service.url);
  await ready(page);
  const took = await page.evaluate(() => {
    const [{ loadEventEnd }] = performance.getEntriesByType('navigation');
    return Math.round(performance.getEntriesByName('geodesicd:picture')[0].startTime - loadEventEnd);
  });
  console.log(`first picture ${took} ms after the page's load, in a browser that has just started`);
  assert.ok(took < 30_000, `${took} ms`);
  const seen = statistics(await picture(page, '01-first-picture'));
  assert.ok(seen.still < 0.85, 'there is more than the background');
  assert.ok(seen.colourful < 0.001, 'clay has no colour');
  assert.match(await page.textContent('.hint'), /source/);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a click floods the surface with the field, and the legend says what the server says', async () => {
  const page = await openMesh(browser, service, knot);
  const clay = await picture(page, '02-clay');
  await page.mouse.click(...KNOT);
  await page.waitForSelector('.legend:not([hidden])');
  const field = await picture(page, '03-field');
  const seen = statistics(field);
  assert.ok(seen.colourful > 0.1, `colourful ${seen.colourful}`);
  assert.ok(seen.colours > 25, `${seen.colours} colours`);
  assert.ok(difference(clay, field) > 0.1);
  const [, from] = await until(async () => /from=([\d.,]+)/.exec(page.url()), 'the source in the link');
  const values = await service.field(knot, `from=f:${from}&method=auto`);
  const most = Math.max(...values.filter(Number.isFinite));
  assert.equal(Number(await page.textContent('.legend .last')), Number(most.toPrecision(4)));
  // More isolines, other colours: another picture of the same field.
  await page.keyboard.press(']');
  const denser = await picture(page, '04-more-isolines');
  const apart = difference(field, denser);
  assert.ok(apart > 0.002 && apart < 0.2, `isolines are lines: ${apart}`);
  await page.keyboard.press('c');
  assert.ok(difference(denser, await picture(page, '05-turbo')) > 0.1);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a dragged target takes the path along, and the field is not asked for again', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(...LEFT);
  await page.waitForSelector('.legend:not([hidden])');
  await page.mouse.click(...RIGHT);
  const first = await pathLength(page);
  const before = await picture(page, '06-path');
  // As many requests for paths as the server answers, never two at once; none for fields.
  let open = 0;
  let most = 0;
  let paths = 0;
  page.on('request', (request) => {
    if (!request.url().includes('/path')) return;
    paths++;
    most = Math.max(most, ++open);
  });
  for (const end of ['requestfinished', 'requestfailed']) {
    page.on(end, (request) => { if (request.url().includes('/path')) open--; });
  }
  const asked = page.asked.length;
  await drag(page, RIGHT, [420, 180], 40);
  await pathLength(page, first);
  const after = await picture(page, '07-path-dragged');
  assert.ok(paths > 1, `${paths} paths while dragging`);
  assert.equal(most, 1, 'one request in flight');
  assert.equal(page.asked.slice(asked).filter((url) => url.includes('/distance')).length, 0);
  const apart = difference(before, after);
  assert.ok(apart > 0.002 && apart < 0.2, `the path moved and the field stayed: ${apart}`);
  // The plane's paths are known: as the crow flies.
  await until(async () => {
    if (!/from=[\d.,]+&to=[\d.,]+/.test(page.url())) return false;
    const fragment = new URLSearchParams(new URL(page.url()).hash.slice(1));
    const { points } = await service.json(`/v1/meshes/${plane}/nearest?point=f:${fragment.get('from')}&point=f:${fragment.get('to')}`);
    const crow = Math.hypot(...points[0].xyz.map((part, axis) => part - points[1].xyz[axis]));
    return Math.abs(Number(await pathLength(page, first)) / crow - 1) < 0.01;
  }, 'the length of the straight line between the points of the link');
  const second = await pathLength(page);
  // Distances stand along it, and can be taken away.
  assert.ok((await page.locator('.labels span').count()) >= 4);
  await page.keyboard.press('l');
  await until(async () => (await page.locator('.labels span').count()) === 0, 'labels gone');
  // Through a via point it is longer.
  await page.keyboard.press('4');
  await page.mouse.click(250, 560);
  assert.ok(Number(await pathLength(page, second)) > Number(second));
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('the method is auto and paths are pulled straight, unless one chooses otherwise', async () => {
  const page = await openMesh(browser, service, plane);
  assert.equal(await page.locator('.method').first().textContent().then((text) => text.startsWith('Auto')), true, 'first in the list');
  assert.ok(await page.getByLabel('Auto').isChecked());
  assert.ok(await page.getByLabel('Pull the path straight').isChecked());
  const { methods } = await service.json('/v1/methods');
  const said = await page.locator('.method').evaluateAll((all) => all.map((each) => [each.querySelector('input').value, each.querySelector('p').textContent]));
  assert.deepEqual(Object.fromEntries(said), Object.fromEntries(methods.map(({ name, about }) => [name, about])), 'in the words of the server');
  await page.mouse.click(...LEFT);
  await page.mouse.click(...RIGHT);
  await pathLength(page);
  const asked = page.asked.find((url) => url.includes('/path?'));
  assert.match(asked, /method=auto/);
  assert.match(asked, /refine=shortest/);
  assert.doesNotMatch(page.url(), /method=|refine=/, 'what is usual is not in the link');
  await page.keyboard.press('r');
  await until(async () => page.url().includes('refine=none'), 'the choice in the link');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('another method: its time, its error as the server has it, and the overlay', async () => {
  const page = await openMesh(browser, service, knot);
  await page.mouse.click(...KNOT);
  await page.waitForSelector('.legend:not([hidden])');
  const automatic = await picture(page, '08-auto');
  await page.getByLabel('Dijkstra').check();
  await until(async () => page.url().includes('method=dijkstra'), 'the method in the link');
  const row = page.locator('.compared tr', { hasText: 'Dijkstra' });
  await until(async () => /\d/.test(await row.locator('.time').textContent()), 'the time');
  const dijkstra = await picture(page, '09-dijkstra');
  const apart = difference(automatic, dijkstra);
  assert.ok(apart > 0.005, `Dijkstra's field is another: ${apart}`);
  await page.getByLabel('Error').check();
  await textAt(page, '.legend h2', (text) => text === 'Error against exact');
  const mean = await textAt(page, '.legend p', (text) => text.startsWith('Mean'));
  const overlay = await picture(page, '10-error');
  assert.ok(difference(dijkstra, overlay) > 0.1);
  const from = /from=([\d.,]+)/.exec(page.url())[1];
  const [tried, exact] = await Promise.all(
    ['dijkstra', 'exact'].map((method) => service.field(knot, `from=f:${from}&method=${method}`)),
  );
  let sum = 0;
  let count = 0;
  exact.forEach((truth, vertex) => {
    if (!(truth > 0 && truth < Infinity)) return;
    sum += Math.abs(tried[vertex] - truth) / truth;
    count++;
  });
  const expected = `Mean ${Number(((100 * sum) / count).toPrecision(2))} %`;
  assert.equal(mean, expected);
  await page.getByRole('button', { name: 'Compare all' }).click();
  await until(async () => {
    const told = await page.locator('.compared .error').allTextContents();
    return told.length === (await page.locator('.method').count()) && told.every((text) => /\d/.test(text));
  }, 'all errors');
  const heads = await page.locator('.compared thead th').allTextContents();
  assert.deepEqual(heads, ['Method', 'Timems', 'Mean error%', 'Largest%'], 'with units');
  for (const name of ['Exact', 'Chen–Han']) {
    const error = await page.locator('.compared tbody tr', { hasText: name }).locator('.error').textContent();
    assert.match(error, /^(< 0\.0001|0|0\.000\d+)$/, 'exact methods agree');
  }
  assert.match(await page.locator('.compared tbody tr').first().textContent(), /^Auto/);
  await picture(page, '11-compared');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a comparison that is stopped says so, and goes on from there when it is asked for again', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3');
  await page.waitForSelector('.legend:not([hidden])');
  // One method's answer does not come.
  let held = true;
  await page.route(/\/distance/, (route) => {
    const { url, body } = { url: route.request().url(), body: route.request().postData() ?? '' };
    return held && (url + body).includes('dijkstra') ? undefined : route.continue();
  });
  await page.getByRole('button', { name: 'Compare all' }).click();
  await until(async () => (await page.locator('.compared tbody tr .error').allTextContents()).some((text) => text !== '–'), 'the first methods');
  await page.locator('.work', { hasText: 'Comparing' }).getByRole('button', { name: 'Cancel' }).click();
  await page.getByText('Stopped before all methods were compared').waitFor();
  assert.equal(await page.locator('.compared tbody tr', { hasText: 'Dijkstra' }).count(), 0);
  held = false;
  await page.getByRole('button', { name: 'Compare all' }).click();
  await page.locator('.compared tbody tr', { hasText: 'Dijkstra' }).waitFor();
  assert.equal(await page.getByText('Stopped before').count(), 0);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('colours that do nothing for what is shown cannot be chosen', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&from=400,0.3,0.3');
  await page.waitForSelector('.legend:not([hidden])');
  const disabled = async () => [await page.getByLabel('Viridis').isDisabled(), await page.getByLabel('Turbo').isDisabled()];
  assert.deepEqual(await disabled(), [false, false]);
  for (const shown of ['Regions', 'Error']) {
    await page.getByLabel(shown, { exact: true }).check();
    await until(async () => (await disabled()).every(Boolean), shown);
  }
  await page.getByLabel('Distance', { exact: true }).check();
  await until(async () => !(await disabled()).some(Boolean), 'distances have a choice');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('several sources divide the surface, and the path begins at the nearest', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(230, 240);
  await page.keyboard.down('Shift');
  await page.keyboard.press('1');
  await page.mouse.click(620, 240);
  await page.mouse.click(430, 560);
  await page.keyboard.up('Shift');
  await until(async () => (await page.locator('.point.source').count()) === 3, 'three sources');
  await page.getByLabel('Regions').check();
  await textAt(page, '.legend h2', (text) => text === 'Nearest source');
  const regions = await picture(page, '12-regions');
  // Light changes a colour a little; each covers a good part.
  for (const colour of ['#e8835a', '#4f8fd0', '#e3c04f']) {
    const share = shareOf(regions, shaded(colour));
    assert.ok(share > 0.03, `${colour} covers ${share}`);
  }
  await page.keyboard.press('3');
  await page.mouse.click(600, 300);
  const near = await pathLength(page);
  const from = new URLSearchParams(new URL(await until(async () => page.url().includes('to=') && page.url(), 'target')).hash.slice(1));
  const to = from.get('to');
  const lengths = await Promise.all(
    from.getAll('from').map(async (source) => (await service.json(`/v1/meshes/${plane}/path?from=f:${source}&to=f:${to}&method=auto&refine=shortest`)).length),
  );
  assert.equal(Number(near), Number(Math.min(...lengths).toPrecision(4)));
  // A source that is taken away leaves two.
  await page.getByRole('button', { name: 'Remove Source 2' }).click();
  await until(async () => (await page.locator('.point.source').count()) === 2, 'two sources');
  assert.ok(Number(await pathLength(page, near)) > Number(near));
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a source inside a face may be the nearest, although others are nearer to its corners', async () => {
  const corners = [[1, 0], [0, 1], [0, 0]]; // the weights of the first two
  const inside = [0.3, 0.4];
  const sources = [...corners, inside].map((weights) => `&from=9000,${weights}`).join('');
  const page = await openMesh(browser, service, plane, `${sources}&to=9000,0.3,0.42`);
  // The edges of this plane are 1 long.
  assert.ok(Number(await pathLength(page)) < 0.1, 'the path begins inside');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

/** A region's colour where the plane is seen straight on. */
function shaded(colour) {
  const parts = [1, 3, 5].map((at) => Math.round(0.88 * parseInt(colour.slice(at, at + 2), 16)));
  return `#${parts.map((part) => Math.min(255, part).toString(16).padStart(2, '0')).join('')}`;
}

test('an arrow goes straight ahead, and turns with its head', async () => {
  const page = await openMesh(browser, service, plane);
  await page.keyboard.press('5');
  await page.mouse.click(300, 380);
  const said = await textAt(page, '.arrow-part .facts', (text) => text.includes('after'));
  assert.match(said, /full length/);
  const right = await picture(page, '13-straight');
  const purple = shareOf(right, '#c77dff');
  assert.ok(purple > 0.0005, `the line is seen: ${purple}`);
  const towards = () => /arrow=[\d.,]+;([-\d.,e]+);/.exec(decodeURIComponent(page.url()))?.[1];
  const before = await until(async () => towards(), 'the arrow in the link');
  // The head is as far on the screen as the arrow is long: a part of the distance to the eye.
  await drag(page, [300 + 102, 380], [300, 280], 12);
  // The link follows the drag, step by step.
  await until(async () => {
    const [x, y] = towards().split(',').map(Number);
    return towards() !== before && y > 0.9 && Math.abs(x) < 0.4;
  }, 'the arrow turned: up the page is up the plane');
  const up = await picture(page, '14-straight-turned');
  assert.ok(difference(right, up) > 0.001);
  // So far that it runs into the boundary.
  await page.locator('#ahead').fill('1000');
  await textAt(page, '.arrow-part .facts', (text) => text.includes('boundary'));
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('kept paths stay in the list and on the mesh, and come back', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(...LEFT);
  await page.mouse.click(...RIGHT);
  const first = await pathLength(page);
  await page.keyboard.press('k');
  await drag(page, RIGHT, [420, 180]);
  await settled(page);
  const second = await page.textContent('#length');
  await page.getByRole('button', { name: 'Keep' }).click();
  await until(async () => (await page.locator('.measures li').count()) === 2, 'two measures');
  assert.deepEqual(await page.locator('.measures .number').allTextContents(), [first, second]);
  const both = await picture(page, '15-measures');
  assert.ok(shareOf(both, '#ffe08a') > 0.0003, 'kept lines are seen');
  await page.locator('.measure').first().click();
  await textAt(page, '#length', (text) => text === first);
  await page.getByRole('button', { name: 'Remove measure A' }).click();
  await until(async () => (await page.locator('.measures li').count()) === 1, 'one measure');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('without a mouse: keys turn, zoom and place points at the cross', async () => {
  const page = await openMesh(browser, service, plane);
  await page.locator('body > canvas').focus();
  const before = await settled(page);
  for (const key of ['ArrowRight', 'ArrowUp', '+']) await page.keyboard.press(key);
  assert.ok(difference(before, await settled(page)) > 0.01, 'the view moved');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.legend:not([hidden])');
  assert.ok(await page.locator('.cross').evaluate((cross) => !cross.hidden));
  for (let n = 0; n < 4; n++) await page.keyboard.press('ArrowRight');
  for (let n = 0; n < 3; n++) await page.keyboard.press('ArrowDown');
  await page.keyboard.press('x');
  await until(async () => !(await page.locator('.legend').isVisible()), 'the points are cleared');
  await page.keyboard.press('?');
  assert.ok(await page.getByRole('dialog', { name: 'Keys and gestures' }).isVisible());
  await picture(page, '16-keys', MESH);
  await page.keyboard.press('Escape');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
