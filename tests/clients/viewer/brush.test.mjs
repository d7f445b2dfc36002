// The brush: faces that are painted are forbidden, or all there is, to whatever is asked; erased, undone, in links.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, pathLength, picture, reload, settled, textAt, until } from './browser.mjs';
import { difference, statistics } from './pixels.mjs';
import { served } from './served.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

const brush = (page) => page.getByLabel('Brush', { exact: true }).check();
const [LEFT, RIGHT] = [[250, 380], [620, 380]];

async function stroke(page, [x, y], [toX, toY], key) {
  await page.mouse.move(x, y);
  if (key) await page.keyboard.down(key);
  await page.mouse.down();
  await page.mouse.move(toX, toY, { steps: 8 });
  await page.mouse.up();
  if (key) await page.keyboard.up(key);
}

/** How many faces the panel says are painted, other than `before`. */
async function painted(page, before = -1) {
  const [count] = await until(async () => {
    const now = Number(/^[\d,]*/.exec(await page.textContent('#painted'))[0].replaceAll(',', ''));
    return now !== before && [now];
  }, `other than ${before} painted faces`);
  return count;
}

/** The faces of the link, as a region of the API. */
const regionIn = (page, as = 'forbid') => until(async () => new RegExp(`[#&]${as}=([\\d,-]+)`).exec(page.url())?.[1], `${as} in the link`);

test('a path goes round what is painted; all is erased and undone', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(...LEFT);
  await page.mouse.click(...RIGHT);
  const straight = await pathLength(page);
  await brush(page);
  assert.match(await page.textContent('.hint'), /forbid/);
  const before = await settled(page);
  const asked = page.asked.length;
  await stroke(page, [430, 300], [430, 480]);
  const longer = await pathLength(page, straight);
  const count = await painted(page, 0);
  const forbid = `faces:${await regionIn(page)}`;
  assert.equal(page.asked.slice(asked).filter((url) => url.includes('/distance')).length, 1, 'a stroke is one question');
  // What was asked is what the picture shows and the server says.
  const { from, to } = Object.fromEntries(new URLSearchParams(new URL(page.url()).hash.slice(1)));
  const said = await service.json(`/v1/meshes/${plane}/path?from=f:${from}&to=f:${to}&method=auto&refine=shortest&forbid=${forbid}`);
  assert.equal(Number(longer), Number(said.length.toPrecision(4)));
  assert.ok(Number(longer) > 1.01 * Number(straight));
  await page.mouse.move(30, 30);
  const hatched = await picture(page, '95-forbidden');
  assert.ok(difference(before, hatched) > 0.01, 'the hatching is seen');
  assert.ok(page.asked.some((url) => url.includes('/distance') && decodeURIComponent(url).includes(`forbid=${forbid}`)));
  // Shift takes paint away, and so does the eraser.
  await stroke(page, [430, 470], [430, 490], 'Shift');
  const less = await painted(page, count);
  assert.ok(less < count, `${less} of ${count}`);
  await page.getByLabel('Erase', { exact: true }).check();
  await stroke(page, [430, 300], [430, 330]);
  assert.ok((await painted(page, less)) < less);
  for (const wanted of [less, count]) {
    await page.keyboard.press('Control+z');
    await until(async () => (await painted(page)) === wanted, `${wanted} faces again`);
  }
  await textAt(page, '#length', (text) => text === longer);
  await page.getByRole('button', { name: 'Undo' }).click();
  await textAt(page, '#length', (text) => text === straight);
  await page.keyboard.press('Control+Shift+z');
  await textAt(page, '#length', (text) => text === longer);
  // A link has it, and what was kept of it.
  await page.keyboard.press('k');
  await page.getByRole('button', { name: 'Clear the painting' }).click();
  await textAt(page, '#length', (text) => text === straight);
  await until(async () => decodeURIComponent(page.url()).includes(`;forbid:${forbid.slice(6)}`), 'the kept path in the link');
  await reload(page);
  await textAt(page, '#length', (text) => text === straight);
  await textAt(page, '.measure .number', (text) => text === longer);
  await page.locator('.measure').click();
  await textAt(page, '#length', (text) => text === longer);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('only what is painted is left, and a point beside it is refused in words', async () => {
  const page = await openMesh(browser, service, plane);
  await brush(page);
  await page.getByLabel('Only these').check();
  await stroke(page, [250, 380], [450, 380]);
  const within = await regionIn(page, 'within');
  await page.getByLabel('Source', { exact: true }).check();
  await page.mouse.click(300, 380);
  await page.waitForSelector('.legend:not([hidden])');
  const from = await until(async () => /from=([\d.,]+)/.exec(page.url())?.[1], 'the source');
  const values = await service.field(plane, `from=f:${from}&method=auto&within=faces:${within}`);
  const most = Math.max(...values.filter(Number.isFinite));
  assert.equal(Number(await page.textContent('.legend .last')), Number(most.toPrecision(4)));
  assert.ok(statistics(await picture(page, '96-within')).colourful > 0.02);
  await page.mouse.click(300, 560);
  await page.locator('.trouble', { hasText: 'not on the part of the surface' }).waitFor();
  await page.getByLabel('Source', { exact: true }).check();
  await page.mouse.click(320, 380);
  await until(async () => (await page.locator('.point.target').count()) === 1, 'both points');
  assert.deepEqual(page.faults.filter((text) => !/422/.test(text)), []);
  await page.context().close();
});

test('the brush by keys, a stroke that is taken back, and a larger brush', async () => {
  const page = await openMesh(browser, service, plane);
  await brush(page);
  await page.mouse.move(300, 300);
  await page.mouse.down();
  await page.mouse.move(400, 300, { steps: 4 });
  await page.keyboard.press('Escape');
  await page.mouse.up();
  assert.equal(await painted(page), 0);
  assert.ok(await page.getByRole('button', { name: 'Undo' }).isDisabled());
  await page.locator('canvas').first().focus();
  await page.keyboard.press('Enter');
  const small = await painted(page, 0);
  await page.keyboard.press('Control+z');
  assert.equal(await painted(page, small), 0);
  await page.locator('#brush-size').fill('50');
  await page.locator('canvas').first().focus();
  await page.keyboard.press('Enter');
  const large = await painted(page, 0);
  // By area: of radii of 0.25 and 0.08.
  assert.ok(Math.abs(large / small / (0.25 / 0.08) ** 2 - 1) < 0.1, `${small}, ${large}`);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a finger paints, and two fingers do not', async () => {
  const page = await openMesh(browser, service, plane, '', { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await page.getByLabel('Brush', { exact: true }).check();
  const finger = await page.context().newCDPSession(page);
  const touch = (type, ...points) => finger.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
  await touch('touchStart', [150, 250]);
  for (let step = 1; step <= 6; step++) await touch('touchMove', [150 + 12 * step, 250]);
  await touch('touchEnd');
  const count = await painted(page, 0);
  const view = page.url();
  await touch('touchStart', [150, 300]);
  await touch('touchStart', [150, 300], [240, 300]);
  for (let step = 1; step <= 4; step++) await touch('touchMove', [150 - 10 * step, 300], [240 + 10 * step, 300]);
  await touch('touchEnd');
  await until(async () => /camera=/.test(page.url()) && page.url() !== view, 'the view was moved');
  assert.equal(await painted(page), count);
  await picture(page, '97-phone-brush', { x: 0, y: 130, width: 390, height: 280 });
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('what is too much for a link is said, and asked all the same', async () => {
  const every = Array.from({ length: 8000 }, (_, index) => 2 * index).join();
  const page = await openMesh(browser, service, plane, `&from=19001,0.3,0.3&forbid=${every}`);
  assert.equal(await painted(page), 8000);
  await page.waitForSelector('.legend:not([hidden])');
  await page.getByText('Export', { exact: true }).click();
  await page.getByRole('button', { name: 'Share link' }).click();
  await textAt(page, '.hint', (text) => text.includes('More is painted than a link can hold'));
  assert.ok(!page.url().includes('forbid') && page.url().includes('from='));
  await brush(page);
  await page.getByRole('button', { name: 'Clear the painting' }).click();
  assert.equal(await painted(page), 0);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('faces that the mesh does not have are left out of a link', async () => {
  const page = await openMesh(browser, service, plane, '&forbid=7,19600-30000&from=400,0.3,0.3');
  await page.locator('.trouble', { hasText: /left out.*forbid=7,19600-30000/ }).waitFor();
  assert.equal(await painted(page), 3);
  for (const wrong of ['9-7', 'all', '1,,2', '-5']) {
    const other = await openMesh(browser, service, plane, `&forbid=${wrong}`);
    assert.equal(await painted(other), 0, wrong);
    await other.context().close();
  }
  await page.context().close();
});
