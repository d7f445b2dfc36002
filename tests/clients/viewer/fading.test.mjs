// A path of other points than those that are seen is never shown as if it were theirs.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, pathLength, picture, settled, until } from './browser.mjs';
import { shareOf } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const POINTS = '&from=9700,0.3,0.3&to=19000,0.25,0.25';
const isStale = (page) => page.locator('.result.stale').count().then((count) => count > 0);

/** A page whose questions for paths can be held back. */
async function heldPage() {
  // On a dark ground and without labels the path is all that is white, but for rings of points.
  const page = await openMesh(browser, service, plane, POINTS, { colorScheme: 'dark' });
  await pathLength(page);
  await page.keyboard.press('l');
  await until(async () => !(await isStale(page)), 'the path at full strength');
  const waiting = [];
  page.hold = (act = (route) => route.continue()) =>
    page.route('**/path**', async (route) => {
      await new Promise((go) => waiting.push(go));
      await act(route).catch(() => undefined); // it was cancelled meanwhile
    });
  page.release = () => waiting.splice(0).forEach((go) => go());
  page.waiting = waiting;
  return page;
}

const strength = async (page) => shareOf(await settled(page), '#ffffff');

const CHANGES = {
  'the target moves': async (page) => { await page.keyboard.press('3'); await page.mouse.click(300, 200); },
  'the source moves': async (page) => { await page.keyboard.press('1'); await page.mouse.click(300, 500); },
  'another source comes': async (page) => { await page.keyboard.press('2'); await page.mouse.click(300, 500); },
  'a via point comes': async (page) => { await page.keyboard.press('4'); await page.mouse.click(300, 500); },
  'the method changes': (page) => page.getByLabel('Dijkstra').check(),
  'it is pulled straight no more': (page) => page.keyboard.press('r'),
};

for (const [what, change] of Object.entries(CHANGES)) {
  test(`${what}: the old path is faded until the new one is there`, async () => {
    const page = await heldPage();
    const full = await strength(page);
    await page.hold();
    const length = await page.textContent('#length');
    await change(page);
    await until(() => page.waiting.length > 0, 'the question');
    assert.ok(await isStale(page), 'at once');
    const faded = await strength(page);
    await picture(page, `75-faded-${what.replaceAll(' ', '-')}`);
    assert.ok(faded < 0.5 * full, `${faded} of ${full} is white`);
    assert.equal(await page.textContent('#length'), length, 'the number is the old one, faded too');
    await until(async () => {
      page.release();
      return !(await isStale(page));
    }, 'the new path');
    assert.ok((await strength(page)) > 1.8 * faded, 'at full strength');
    assert.deepEqual(page.faults, []);
    await page.context().close();
  });
}

test('a path that does not come leaves the old one faded, and going back makes it whole', async () => {
  const page = await heldPage();
  await page.hold((route) => route.fulfill({ status: 504, contentType: 'application/problem+json', body: '{"code": "deadline", "status": 504, "title": "late"}' }));
  await page.mouse.click(300, 200);
  await until(async () => {
    page.release();
    return (await page.locator('.trouble').count()) > 0;
  }, 'the error');
  await page.waitForTimeout(400);
  assert.ok(await isStale(page), 'after the error');
  await page.keyboard.press('Escape');
  await page.waitForTimeout(400);
  assert.ok(await isStale(page), 'after all is stopped');
  await page.keyboard.press('Control+z');
  await until(async () => !(await isStale(page)), 'the old points are the present ones again');
  await page.context().close();
});

test('while a target is dragged the path is faded throughout, and whole at rest', async () => {
  const page = await openMesh(browser, service, plane, POINTS);
  await pathLength(page);
  await page.keyboard.press('3');
  await page.mouse.click(300, 200);
  await until(async () => !(await isStale(page)), 'the path');
  // Each time that it becomes whole is noted, and how long the target had rested by then: in a
  // flicker that is short, however slow the machine is.
  await page.evaluate(() => {
    globalThis.rests = [];
    let moved = 0;
    let held = false;
    for (const [type, holds] of [['pointerdown', true], ['pointermove', null], ['pointerup', false]]) {
      addEventListener(type, () => {
        moved = performance.now();
        held = holds ?? held;
      }, { capture: true });
    }
    const result = document.querySelector('.result');
    let wasStale = false;
    new MutationObserver(() => {
      const isStale = result.classList.contains('stale');
      if (wasStale && !isStale && held) globalThis.rests.push(performance.now() - moved);
      wasStale = isStale;
    }).observe(result, { attributes: true, attributeFilter: ['class'] });
  });
  await page.mouse.move(300, 200);
  await page.mouse.down();
  await page.mouse.move(500, 360, { steps: 60 });
  await until(async () => !(await isStale(page)), 'at rest, though it is held');
  await page.mouse.move(400, 300, { steps: 60 });
  await page.mouse.up();
  await until(async () => !(await isStale(page)), 'at rest');
  const rests = await page.evaluate(() => globalThis.rests);
  assert.ok(rests.length >= 1, 'it was whole while it was held at rest');
  assert.deepEqual(rests.filter((rest) => rest < 250), [], 'it became whole after so many milliseconds of rest');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
