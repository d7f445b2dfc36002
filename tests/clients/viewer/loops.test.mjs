// Loops on the page: through points, tightened, and tapes round one point; what is asked, what is drawn and said,
// that all of it is undone, and that links carry it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, picture, reload, settled, textAt, until } from './browser.mjs';
import { shareOf } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const holes = await service.sample('plane_three_holes');
const knot = await service.sample('torus_knot');
const ball = await service.sample('sphere');

const LINE = '#6ff7e2';
const tool = (page) => page.getByLabel('Loop', { exact: true }).check();
const loops = (page) => page.asked.filter((url) => url.includes('/loop'));

/** The length of the drawn line as the panel says it, other than `before`. */
async function round(page, before = '') {
  await page.locator('.loop-part:not(.stale)').waitFor();
  return textAt(page, '.loop-part:not(.stale) #round', (text) => /\d/.test(text) && text !== before);
}
const spots = (page) => until(async () => /loop=([^&]+)/.exec(page.url())?.[1], 'the loop in the link');

test('clicked points are joined, closed in one click, tightened in another, and undone', async () => {
  const page = await openMesh(browser, service, holes);
  const bare = await settled(page);
  await tool(page);
  assert.match(await page.textContent('.hint'), /points of a loop/);
  for (const at of [[210, 160], [655, 160], [655, 605], [210, 605]]) await page.mouse.click(...at);
  const open = await round(page);
  assert.deepEqual(loops(page), [], 'an open line is paths');
  await page.getByRole('button', { name: 'Close the loop' }).click();
  const closed = await round(page, open);
  assert.match(await page.textContent('#loop-said'), /Bends by/);
  const through = await picture(page, '90-loop-through');
  assert.ok(shareOf(through, LINE) > 0.002 && shareOf(bare, LINE) === 0, `a line is drawn: ${shareOf(through, LINE)}`);
  await page.getByRole('radio', { name: 'Tightened' }).check();
  const tight = await round(page, closed);
  assert.match(await page.textContent('#loop-said'), /^A closed geodesic · .* before it was tightened$/);
  const drawn = await picture(page, '91-loop-around');
  assert.ok(shareOf(drawn, LINE) > 0.001);
  // The server says the same of the points that the link has.
  const [kind, ...points] = (await until(async () => /loop=(around[^&]+)/.exec(page.url())?.[1], 'the link')).split(';');
  const said = async (how) => Number((await service.json(`/v1/meshes/${holes}/loop?${points.map((spot) => `${how}=f:${spot}`).join('&')}`)).length.toPrecision(4));
  assert.equal(kind, 'around');
  assert.equal(Number(tight), await said('around'));
  assert.equal(Number(closed), await said('through'));
  assert.ok(Number(tight) < Number(closed));
  await page.getByRole('button', { name: 'Undo' }).click();
  await textAt(page, '#round', (text) => text === closed);
  await page.keyboard.press('Control+z');
  await textAt(page, '#round', (text) => text === open);
  for (let step = 0; step < 4; step++) await page.keyboard.press('Control+z');
  await until(async () => (await page.locator('.point.loop').count()) === 0, 'all is undone');
  assert.ok(shareOf(await settled(page), LINE) === 0);
  await page.keyboard.press('Control+Shift+z');
  assert.equal(await page.locator('.point.loop').count(), 1);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a line ends with Enter, with a double click and with a click on its first point; a link brings it back', async () => {
  const page = await openMesh(browser, service, holes);
  await tool(page);
  const [a, b, c] = [[210, 160], [655, 160], [430, 605]];
  for (const at of [a, b, c]) await page.mouse.click(...at);
  await round(page);
  await page.keyboard.press('Enter');
  await textAt(page, '.loop-part h2', (text) => text === 'Loop through points');
  const first = await round(page);
  // The next point begins another one.
  for (const at of [a, b]) await page.mouse.click(...at);
  await page.mouse.dblclick(...c);
  await textAt(page, '.loop-part h2', (text) => text === 'Loop through points');
  await textAt(page, '#round', (text) => text === first);
  for (const at of [a, b, c, a]) await page.mouse.click(...at);
  await textAt(page, '.loop-part h2', (text) => text === 'Loop through points');
  await textAt(page, '#round', (text) => text === first);
  assert.equal((await spots(page)).split(';').length, 4);
  // A point is dragged in one step.
  await page.mouse.move(...c);
  await page.mouse.down();
  await page.mouse.move(430, 540, { steps: 6 });
  await page.mouse.up();
  const dragged = await round(page, first);
  await page.keyboard.press('Control+z');
  await textAt(page, '#round', (text) => text === first);
  await page.keyboard.press('Control+Shift+z');
  await textAt(page, '#round', (text) => text === dragged);
  await until(async () => page.url().includes('loop=through'), 'the link');
  await reload(page);
  await textAt(page, '#round', (text) => text === dragged);
  await page.keyboard.press('x');
  await until(async () => !(await page.locator('.loop-part').isVisible()), 'cleared');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a tape lies round a clicked point in the plane that is seen, or across an axis', async () => {
  const page = await openMesh(browser, service, knot);
  await tool(page);
  await page.mouse.click(392, 314);
  await page.getByRole('button', { name: 'As seen' }).click();
  const tight = await round(page);
  assert.match(await page.textContent('#loop-said'), /closed geodesic/);
  const [kind, normal, at] = (await until(async () => /loop=(plane[^&]+)/.exec(page.url())?.[1], 'the link')).split(';');
  assert.equal(kind, 'plane');
  const ask = async (more) => (await service.json(`/v1/meshes/${knot}/loop?at=f:${at}&normal=${normal}${more}`)).length;
  assert.equal(Number(tight), Number((await ask('')).toPrecision(4)));
  assert.ok(shareOf(await picture(page, '92-loop-tightened'), LINE) > 0.0002);
  await page.getByLabel('Tape', { exact: true }).check();
  const tape = await round(page, tight);
  assert.equal(Number(tape), Number((await ask('&hull=1')).toPrecision(4)));
  await picture(page, '93-tape');
  await page.getByText('Export', { exact: true }).click();
  const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Loop · GLB' }).click()]);
  assert.equal(saved.suggestedFilename(), 'torus_knot.loop.glb');
  await page.getByRole('button', { name: 'Across x' }).click();
  await round(page, tape);
  await until(async () => page.url().includes('loop=tape;1,0,0;'), 'the plane in the link');
  await page.keyboard.press('Control+z');
  await textAt(page, '#round', (text) => text === tape);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('why there is no loop is said where its length would stand', async () => {
  const page = await openMesh(browser, service, ball);
  await tool(page);
  await page.mouse.click(430, 330);
  await page.getByRole('button', { name: 'Across z' }).click();
  await textAt(page, '#loop-said', (text) => text === 'No loop: the loop contracts to a point: it goes round nothing that holds it.');
  assert.equal(await page.textContent('#round'), '–');
  await picture(page, '94-no-loop');
  await page.getByLabel('Tape', { exact: true }).check();
  await round(page);
  // The browser says of itself that an answer was a refusal.
  assert.deepEqual(page.faults.filter((text) => !/422/.test(text)), []);
  await page.context().close();
});

test('links that say loops wrongly say none', async () => {
  for (const wrong of ['through;5,0.3,0.3', 'plane;0,0,0;5,0.3,0.3', 'plane;5,0.3,0.3', 'knot;5,0.3,0.3;6,0.3,0.3', 'around;5,0.3,0.3;6,0.3,0.3', 'tape;1,0,0;5,0.3,0.3;6,0.3,0.3']) {
    const page = await openMesh(browser, service, holes, `&loop=${wrong}`);
    assert.equal(await page.locator('.loop-part').isVisible(), false, wrong);
    assert.deepEqual(page.faults, []);
    await page.context().close();
  }
  const page = await openMesh(browser, service, holes, '&loop=through;5,0.3,0.3;99999999,0.3,0.3');
  await page.locator('.trouble', { hasText: /left out.*loop=99999999/ }).waitFor();
  await page.context().close();
});
