// Ways that cost least: quick or easy on foot by the slope, and over painted faces that cost more; what the page
// says of them is what the server answers. Of a server that does not know of costs nothing is shown.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, pageWithout, pathLength, picture, ready, settled, textAt, until } from './browser.mjs';
import { difference } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const terrain = await service.sample('terrain');
const plane = await service.sample('plane');
const POINTS = '&from=2000,0.3,0.3&to=60000,0.3,0.3';

const least = (page, name) => page.getByRole('radio', { name, exact: true });
const asked = (page) => page.asked.map(decodeURIComponent);
const askedFor = (page, query, what) => until(async () => asked(page).some((url) => url.includes(`/${query}?`) && url.includes(what)), `${query} with ${what}`);
const lengthIs = (page, text) => textAt(page, '#length', (now) => now === text);
/** The cost that the panel says, in the server's unit. */
async function costSaid(page, pattern) {
  const text = await textAt(page, '.result .facts', (now) => pattern.test(now));
  return Number(pattern.exec(text)[1].replaceAll(',', ''));
}
function near(said, cost, what) {
  assert.ok(Math.abs(said / cost - 1) < 1e-3, `${what}: the page says ${said}, the server ${cost}`);
}

test('distances are seconds or joules by the axis of the heights, and lengths again when it is undone', async () => {
  const page = await openMesh(browser, service, terrain, `${POINTS}&up=y`);
  const short = await pathLength(page);
  assert.equal(await page.textContent('.legend h2'), 'Distance');
  assert.equal(await page.getByText('Heights along').isVisible(), false);
  await least(page, 'Quickest').check();
  await textAt(page, '.legend h2', (text) => text === 'Seconds on foot');
  for (const query of ['distance', 'path']) await askedFor(page, query, 'method=steiner&slope=tobler&up=0,1,0');
  assert.ok(page.asked.every((url) => !url.includes('slope') || !url.includes('refine=shortest')));
  await until(async () => Number((await page.textContent('#length')).replaceAll(',', '')) > Number(short), 'a longer way');
  const quick = await page.textContent('#length');
  const path = (slope, up = '0,1,0') => service.json(`/v1/meshes/${terrain}/path?from=f:2000,0.3,0.3&to=f:60000,0.3,0.3&method=steiner&slope=${slope}&up=${up}`);
  const minutes = await costSaid(page, /^([\d.,]+) min on foot · Steiner/);
  near(60 * minutes, (await path('tobler')).cost, 'seconds');
  assert.ok(await page.getByLabel('Exact', { exact: false }).first().isDisabled());
  for (const name of ['Area within a radius', 'Keep']) assert.equal(await page.getByText(name, { exact: true }).isVisible(), false, name);
  await picture(page, '103-on-foot');
  await until(async () => page.url().includes('walking=tobler,y'), 'the link');
  await least(page, 'Least energy').check();
  await textAt(page, '.legend h2', (text) => text === 'Joules per kilogram');
  const energy = await costSaid(page, /^([\d.,]+) kJ\/kg on foot · Steiner/);
  near(1000 * energy, (await path('energy')).cost, 'joules');
  assert.equal(await page.textContent('.result h2'), 'Way of least energy');
  await page.getByRole('radio', { name: 'Z', exact: true }).check();
  await askedFor(page, 'distance', 'slope=energy&up=0,0,1');
  await until(async () => page.url().includes('walking=energy,z'), 'the link');
  assert.ok(page.url().includes('up=y'), 'the view stays');
  await page.keyboard.press('Control+z');
  await textAt(page, '.result .facts', (text) => text.startsWith(`${energy} `));
  await page.keyboard.press('Control+z');
  await lengthIs(page, quick);
  await page.keyboard.press('Control+z');
  await textAt(page, '.legend h2', (text) => text === 'Distance');
  await lengthIs(page, short);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('of several sources the way begins at that of least cost', async () => {
  const page = await openMesh(browser, service, terrain, '&from=2000,0.3,0.3&from=2003,0.3,0.3&from=30000,0.2,0.2&to=60000,0.3,0.3&up=y&walking=energy,y');
  const said = await costSaid(page, /^([\d.,]+) J\/kg on foot/);
  const ways = await Promise.all(['2000,0.3,0.3', '2003,0.3,0.3', '30000,0.2,0.2'].map((from) =>
    service.json(`/v1/meshes/${terrain}/path?from=f:${from}&to=f:60000,0.3,0.3&method=steiner&slope=energy&up=0,1,0`)));
  const best = Math.min(...ways.map(({ cost }) => cost));
  near(said, best, 'joules from the best source');
  assert.ok(await page.getByLabel('Cells').isDisabled(), 'cells are of lengths');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('painted faces have a weight: the path goes round them where that is cheaper', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(250, 380);
  await page.mouse.click(620, 380);
  const straight = await pathLength(page);
  const bare = await settled(page);
  await page.getByLabel('Brush', { exact: true }).check();
  await page.getByRole('radio', { name: 'Weighted' }).check();
  assert.match(await page.textContent('.hint'), /weight/);
  await page.mouse.move(430, 340);
  await page.mouse.down();
  await page.mouse.move(430, 420, { steps: 8 });
  await page.mouse.up();
  await textAt(page, '#painted', (text) => /weighted: on the hatched ones each length costs 3 times as much$/.test(text));
  const [, listed] = await until(async () => /[#&]weights=3\*([\d,-]+)/.exec(page.url()), 'the weights in the link');
  const { from, to } = Object.fromEntries(new URLSearchParams(new URL(page.url()).hash.slice(1)));
  const answer = (weight) => service.json(`/v1/meshes/${plane}/path?from=f:${from}&to=f:${to}&method=steiner&weights=${weight}*faces:${listed}`);
  const said = await costSaid(page, /^cost ([\d.,]+) · Steiner/);
  near(said, (await answer(3)).cost, 'length times weight');
  assert.ok(said > Number(straight));
  assert.equal(await page.textContent('.legend h2'), 'Length times weight');
  await page.mouse.move(5, 5);
  assert.ok(difference(bare, await picture(page, '106-weighted')) > 0.01, 'the hatching is seen');
  // Cheaper ground: the slider is on a scale of powers.
  await page.locator('#weight').fill('-100');
  await until(async () => page.url().includes('weights=0.1*'), 'the link');
  const cheap = async () => Number(/^cost ([\d.,]+) · Steiner/.exec(await page.textContent('.result .facts'))?.[1]);
  await until(async () => (await cheap()) < Number(straight), 'a cheaper path');
  near(await cheap(), (await answer(0.1)).cost, 'length times weight');
  // On foot, too; and undone all the way.
  await least(page, 'Quickest').check();
  await askedFor(page, 'path', `slope=tobler&up=0,1,0&weights=0.1*faces:${listed}`);
  for (const _ of ['on foot', 'the slider', 'the stroke']) await page.keyboard.press('Control+z');
  await lengthIs(page, straight);
  await textAt(page, '.legend h2', (text) => text === 'Distance');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('points on the edges bring costs down, and what is about lengths waits', async () => {
  const page = await openMesh(browser, service, terrain, `${POINTS}&up=y&method=exact`);
  await pathLength(page);
  await page.getByLabel('Error', { exact: true }).check();
  await textAt(page, '.legend h2', (text) => text === 'Error against exact');
  await least(page, 'Quickest').check();
  await textAt(page, '.legend h2', (text) => text === 'Seconds on foot');
  await page.getByText('Least costs are computed by Steiner.').waitFor();
  const cost = await costSaid(page, /^([\d.,]+) min on foot · Steiner/);
  const before = page.asked.length;
  for (const key of ['m', 'r']) await page.keyboard.press(key); // neither has a part in it
  await page.locator('#per-edge').fill('8');
  await askedFor(page, 'path', 'points_per_edge=8&slope=tobler');
  await until(async () => (await costSaid(page, /^([\d.,]+) min on foot/)) < cost, 'a lower cost');
  assert.equal(asked(page).slice(before).filter((url) => url.includes('/path?')).length, 1);
  // Another mesh has another way up.
  await page.locator('#mesh').selectOption({ label: 'plane.glb' });
  await ready(page);
  await until(async () => page.url().includes(plane) && !page.url().includes('walking'), 'the plane');
  assert.ok(await least(page, 'Shortest').isChecked());
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('least costs begin at points: there is no curve beside them', async () => {
  const page = await openMesh(browser, service, plane);
  await page.getByLabel('Brush', { exact: true }).check();
  await page.getByRole('radio', { name: 'Weighted' }).check();
  await page.getByLabel('Loop', { exact: true }).check();
  for (const place of [[250, 250], [300, 400]]) await page.mouse.click(...place);
  assert.ok(await page.getByRole('button', { name: 'Measure from it' }).isDisabled());
  await page.getByRole('button', { name: 'Make it a wall' }).click();
  assert.deepEqual(page.faults, []);
  await page.context().close();
  const opened = await openMesh(browser, service, plane, '&curve=5,0.3,0.3;900,0.3,0.3&walking=tobler,y&weights=3*faces:7-99');
  await textAt(opened, '.legend h2', (text) => text === 'Distance');
  await opened.getByText('Least costs begin at points, not at lines.').waitFor();
  assert.ok(await least(opened, 'Quickest').isDisabled());
  assert.deepEqual(opened.faults, []);
  await opened.context().close();
});

test('what a link says wrongly of costs is left out', async () => {
  const page = await openMesh(browser, service, plane, '&from=5,0.3,0.3&to=9000,0.3,0.3&walking=tobler,w&weights=1e9*1-5');
  await pathLength(page);
  assert.equal(await page.textContent('.legend h2'), 'Distance');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('what an older server does not know of is not shown', async () => {
  const page = await pageWithout(browser, 'max_slopes');
  await page.goto(`${service.url}#mesh=${terrain}${POINTS}`);
  await ready(page);
  await pathLength(page);
  assert.equal(await least(page, 'Quickest').isVisible(), false);
  await page.getByLabel('Brush', { exact: true }).check();
  assert.ok(await page.getByRole('radio', { name: 'Weighted' }).isDisabled());
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
