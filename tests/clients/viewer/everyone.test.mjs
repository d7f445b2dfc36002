// The page for everyone: axe's rules in every state and theme, phones and their fingers,
// readers who want no motion.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { axe, openMesh, pathLength, picture, ready, reload, until } from './browser.mjs';
import { difference, statistics } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

const FULL =
  '&from=9700,0.3,0.3&from=300,0.2,0.2&via=4000,0.2,0.5&to=19000,0.25,0.25&arrow=8000,0.3,0.3;1,0.4,0;40' +
  '&kept=wavefront;0;9700,0.3,0.3;19000,0.25,0.25&show=cells&loop=through;9000,0.3,0.3;9100,0.2,0.2;12000,0.3,0.3&forbid=15000-15040';
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };
const ON_PHONE = { x: 0, y: 130, width: 390, height: 280 };

/** What axe finds that is serious or worse. */
async function faultsFound(page) {
  await page.evaluate(await readFile(axe, 'utf8'));
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ['violations'] }));
  return violations
    .filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes.map(({ target, failureSummary }) => `${target} ${failureSummary}`).join('; ')}`);
}

for (const colorScheme of ['light', 'dark']) {
  test(`axe finds nothing serious in ${colorScheme}: empty-handed, with everything, with its dialogue`, async () => {
    const page = await openMesh(browser, service, plane, '', { colorScheme });
    assert.deepEqual(await faultsFound(page), [], 'at first');
    await page.context().close();
    const full = await openMesh(browser, service, plane, FULL, { colorScheme });
    await pathLength(full);
    for (const part of ['Export', 'Profile']) await full.getByText(part, { exact: true }).click();
    await full.getByText('Import options').click();
    await full.getByRole('button', { name: 'Compare all' }).click();
    await until(async () => (await full.locator('.compared tbody tr').count()) > 7, 'the table');
    await picture(full, `40-everything-${colorScheme}`);
    assert.deepEqual(await faultsFound(full), [], 'with everything');
    await full.keyboard.press('?');
    assert.deepEqual(await faultsFound(full), [], 'with its dialogue');
    assert.deepEqual(full.faults, []);
    await full.context().close();
  });
}

test('dark and light: as the system says, and by the switch', async () => {
  const page = await openMesh(browser, service, plane, '', { colorScheme: 'dark' });
  const dark = await picture(page, '41-dark');
  await page.getByRole('button', { name: 'Dark or light' }).click();
  const light = await picture(page, '42-light');
  assert.ok(difference(dark, light) > 0.5);
  await reload(page);
  await ready(page);
  assert.ok(difference(light, await picture(page, '43-light-again')) < 0.01, 'the switch is remembered');
  await page.context().close();
});

test('on a phone: a sheet below, fingers place and drag', async () => {
  const page = await openMesh(browser, service, plane, '', PHONE);
  const clay = await picture(page, '44-phone', ON_PHONE);
  assert.equal(await page.locator('.hint').textContent(), 'Tap the surface to place a source');
  await page.touchscreen.tap(150, 250);
  await page.waitForSelector('.legend:not([hidden])');
  await page.touchscreen.tap(240, 330);
  const first = await pathLength(page);
  const path = await picture(page, '45-phone-path', ON_PHONE);
  assert.ok(difference(clay, path) > 0.05);
  assert.ok(statistics(path).colourful > 0.05);
  // A finger that drags the target, as the browser sends it.
  const finger = await page.context().newCDPSession(page);
  const touch = (type, ...points) =>
    finger.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
  await touch('touchStart', [240, 330]);
  for (let step = 1; step <= 8; step++) await touch('touchMove', [240 - 5 * step, 330 - 12 * step]);
  await touch('touchEnd');
  await pathLength(page, first);
  // Elsewhere two fingers zoom.
  const before = await picture(page, '46-phone-dragged', ON_PHONE);
  await touch('touchStart', [60, 500 - 200], [330, 300]);
  for (let step = 1; step <= 6; step++) await touch('touchMove', [60 + 12 * step, 300], [330 - 12 * step, 300]);
  await touch('touchEnd');
  assert.ok(difference(before, await picture(page, '47-phone-zoomed', ON_PHONE)) > 0.02);
  assert.equal(await page.locator('.point').count(), 2, 'two fingers place nothing');
  // Everything open, as far as a finger can scroll.
  for (const part of ['Profile', 'Export']) await page.getByText(part, { exact: true }).tap();
  await page.getByText('Import options').tap();
  await picture(page, '50-phone-all-open', ON_PHONE);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true, 'nothing hangs over');
  for (const [name, part] of [['51-phone-import', '.place-part'], ['52-phone-profile', '#along'], ['53-phone-methods', '.methods']]) {
    await page.locator(part).scrollIntoViewIfNeeded();
    await picture(page, name, ON_PHONE);
  }
  // Folded, the sheet leaves its head.
  const height = () => page.locator('.panel').evaluate((panel) => panel.getBoundingClientRect().height);
  const unfolded = await height();
  await page.getByRole('button', { name: 'Panel' }).tap();
  await until(async () => (await height()) < unfolded / 3, 'folded');
  await picture(page, '48-phone-folded', ON_PHONE);
  // Whatever a finger meets is large enough.
  await page.getByRole('button', { name: 'Panel' }).tap();
  const small = await page.evaluate(() =>
    [...document.querySelectorAll('button, select, summary, .choice label, .methods label, .check')]
      .map((each) => ({ name: each.textContent.trim() || each.ariaLabel, box: each.getBoundingClientRect() }))
      .filter(({ box }) => box.width > 0 && (box.height < 43.5 || box.width < 43.5))
      .map(({ name, box }) => `${name}: ${box.width} x ${box.height}`),
  );
  assert.deepEqual(small, []);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true, 'nothing hangs over');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('where fingers point, the sheet of keys speaks of taps', async () => {
  const page = await openMesh(browser, service, plane, '', PHONE);
  await page.getByRole('button', { name: 'Keys and gestures' }).tap();
  const sheet = await page.locator('dialog[open]').textContent();
  assert.ok(/Tap.*Pinch/s.test(sheet) && !/Click/.test(sheet), sheet);
  await picture(page, '54-phone-keys', ON_PHONE);
  await page.context().close();
});

test('who wants no motion sees the field at once', async () => {
  const page = await openMesh(browser, service, plane, '', { reducedMotion: 'reduce' });
  await page.mouse.click(430, 380);
  await page.waitForSelector('.legend:not([hidden])');
  const seen = statistics(await picture(page, '49-no-motion'));
  assert.ok(seen.colourful > 0.1);
  await page.context().close();
});
