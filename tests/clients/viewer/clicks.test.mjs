// How many clicks it takes to do what the page is for: at most two, beside those that say where on the surface.
// And each is taken back by Ctrl Z, key by key, to what was there before.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, settled, until } from './browser.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const MOST = 2;
const LINE = [[430, 250], [450, 380], [430, 500]];

/** A page that counts: clicks on its controls, and steps that a reader takes, of which each is one Ctrl Z. */
async function counting(more = '') {
  const page = await openMesh(browser, service, plane, more);
  const counted = { clicks: 0, steps: 0 };
  const on = async (control) => {
    await control.click();
    counted.clicks++;
  };
  const radio = (name) => on(page.locator('label', { has: page.getByRole('radio', { name, exact: true }) }));
  const button = (name) => on(page.getByRole('button', { name, exact: true }));
  const place = async (...places) => {
    for (const at of places) {
      await page.mouse.click(...at);
      counted.steps++;
    }
  };
  return { page, counted, radio, button, place };
}

/** What the page's link says, without the tool in hand, once it says what was done. */
async function said(page) {
  await page.waitForSelector('body:not([data-link])');
  return new URL(page.url()).hash;
}

async function bothWays(page, before, after, steps) {
  assert.notEqual(after, before, 'something was done');
  for (let step = 0; step < steps; step++) await page.keyboard.press('Control+z');
  await until(async () => (await said(page)) === before, `what was there before: ${before}`, () => `; now ${page.url()}`);
  for (let step = 0; step < steps; step++) await page.keyboard.press('Control+Shift+z');
  await until(async () => (await said(page)) === after, `all of it again: ${after}`, () => `; now ${page.url()}`);
}

const TWO = '&from=3000,0.3,0.3&from=12000,0.3,0.3';
const PATH = '&from=3000,0.3,0.3&to=12000,0.3,0.3';

const TASKS = [
  { name: 'a curve to measure from', async run({ radio, button, place, counted }) {
    await radio('Loop');
    await place(...LINE);
    await button('Measure from it');
    counted.steps++;
  } },
  { name: 'a wall', from: PATH, async run({ radio, button, place, counted }) {
    await radio('Loop');
    await place(...LINE);
    await button('Make it a wall');
    counted.steps++;
  } },
  { name: 'faces that are forbidden by a brush', from: PATH, async run({ page, radio, counted }) {
    await radio('Brush');
    await page.mouse.move(...LINE[0]);
    await page.mouse.down();
    await page.mouse.move(...LINE[2], { steps: 6 });
    await page.mouse.up();
    counted.steps++;
  } },
  { name: 'the quickest way', from: PATH, async run({ radio, counted }) {
    await radio('Quickest');
    counted.steps++;
  } },
  { name: 'the way of least energy', from: PATH, async run({ radio, counted }) {
    await radio('Least energy');
    counted.steps++;
  } },
  { name: 'a loop through points', async run({ radio, button, place, counted }) {
    await radio('Loop');
    await place(...LINE, [250, 400]);
    await button('Close the loop');
    counted.steps++;
  } },
  { name: 'cells', from: TWO, async run({ radio, counted }) {
    await radio('Cells');
    counted.steps++;
  } },
];

for (const { name, from = '', run } of TASKS) {
  test(`${name}: at most ${MOST} clicks, and undone`, async () => {
    const task = await counting(from);
    const { page, counted } = task;
    await settled(page);
    const before = await said(page);
    await run(task);
    assert.ok(counted.clicks <= MOST, `${counted.clicks} clicks`);
    await bothWays(page, before, await said(page), counted.steps);
    assert.deepEqual(page.faults, []);
    await page.context().close();
  });
}

test('cells are taken back before the source that they came after', async () => {
  const { page, radio } = await counting('&from=3000,0.3,0.3');
  await page.getByLabel('Add', { exact: true }).check();
  await page.mouse.click(450, 400);
  await radio('Cells');
  await page.locator('.cells-part').waitFor();
  await page.keyboard.press('Control+z');
  await page.locator('.cells-part').waitFor({ state: 'hidden' });
  assert.equal(await page.locator('.point.source').count(), 2);
  await page.keyboard.press('Control+z');
  assert.equal(await page.locator('.point.source').count(), 1);
  // A source that goes takes the cells along, in one step.
  for (const _ of ['the source', 'the cells']) await page.keyboard.press('Control+Shift+z');
  await page.locator('.cells-part').waitFor();
  await page.getByRole('button', { name: 'Remove Source 2' }).click();
  await page.locator('.cells-part').waitFor({ state: 'hidden' });
  await page.keyboard.press('Control+z');
  await page.locator('.cells-part').waitFor();
  assert.equal(await page.locator('.point.source').count(), 2);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
