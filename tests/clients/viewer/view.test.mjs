// How the mesh stands and is looked at: which axis is up, the whole of it again, its edges.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drop, openMesh, pathLength, picture, ready, settled, until } from './browser.mjs';
import { difference, shareOf, statistics } from './pixels.mjs';
import { served } from './served.mjs';
import { wavyMesh, wavyObj } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');

/** Drops a file and waits until it is shown. */
async function show(page, name, bytes) {
  const was = await page.locator('#mesh').inputValue();
  await drop(page, name, bytes);
  await until(async () => ![was, ''].includes(await page.locator('#mesh').inputValue()), `${name} chosen`);
  await ready(page);
}

test('glTF is believed that y is up; other formats have a switch, which is remembered', async () => {
  const page = await openMesh(browser, service, plane);
  await show(page, 'waves.glb', wavyMesh(60));
  assert.ok(await page.getByLabel('Y up').isChecked(), 'glTF says so');
  const wall = await picture(page, '60-gltf-y-up');
  await page.getByLabel('Z up').check();
  await until(async () => page.url().includes('up=z'), 'the choice in the link');
  assert.ok(difference(wall, await picture(page, '61-gltf-z-up')) > 0.05);
  await show(page, 'hills.obj', wavyObj(50));
  assert.ok(await page.getByLabel('Z up').isChecked(), 'a guess by the shape: it is low in z');
  await page.getByLabel('Y up').check();
  await show(page, 'hills_too.obj', wavyObj(51));
  assert.ok(await page.getByLabel('Y up').isChecked(), 'as it was chosen last');
  await page.getByLabel('Z up').check();
  await show(page, 'waves_too.glb', wavyMesh(61));
  assert.ok(await page.getByLabel('Y up').isChecked(), 'and glTF is believed again');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('each axis that the key puts up stands in the panel', async () => {
  const page = await openMesh(browser, service, plane);
  for (const axis of ['Z', 'X', 'Y']) {
    await page.keyboard.press('u');
    await until(async () => page.getByLabel(`${axis} up`).isChecked(), `${axis} up`);
    if (axis === 'X') {
      await page.getByLabel('X up').scrollIntoViewIfNeeded();
      await picture(page, '68-x-up');
    }
  }
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('whoever has lost the mesh from sight has it back', async () => {
  const page = await openMesh(browser, service, plane);
  const first = await settled(page);
  await page.mouse.move(60, 60);
  await page.mouse.down();
  await page.mouse.move(300, 200, { steps: 6 });
  await page.mouse.up();
  assert.ok(difference(first, await settled(page)) > 0.02);
  await page.getByRole('button', { name: 'Reset view' }).click();
  assert.ok(difference(first, await settled(page)) < 0.001);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('edges, units and a scale', async () => {
  const page = await openMesh(browser, service, plane);
  const smooth = await settled(page);
  await page.getByLabel('Edges of the mesh').check();
  const seen = await picture(page, '62-edges');
  assert.ok(difference(smooth, seen) > 0.1, 'edges are seen');
  await page.keyboard.press('e');
  assert.ok(difference(smooth, await settled(page)) < 0.001);
  assert.match(await page.textContent('.mesh-part .facts'), /99\.00 × 99\.00 × 0 m$/, 'glTF is in metres');
  assert.equal(await page.textContent('.scale'), '20 m');
  // As long as it says: the plane is 99 wide, and fills so many pixels.
  const width = await page.locator('.scale i').evaluate((bar) => bar.getBoundingClientRect().width);
  assert.ok(Math.abs(width / 20 - 487 / 99) < 0.1, `${width} pixels`);
  await show(page, 'hills.obj', wavyObj(50));
  assert.match(await page.textContent('.mesh-part .facts'), /units$/, 'OBJ does not say');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('edges lie below the path', async () => {
  const page = await openMesh(browser, service, plane, '&from=0,0.3,0.3&to=19600,0.3,0.3&ticks=0&lines=0');
  await pathLength(page);
  const core = async () => shareOf(await settled(page), '#ffffff');
  const bare = await core();

  assert.ok(bare > 0.001, 'the path is white');
  await page.keyboard.press('e');
  assert.ok((await core()) > 0.97 * bare, 'as white as without edges');
  await picture(page, '69-edges-below-path');
  await page.context().close();
});

test('vertices in no face, be they far away, do not count for the view', async () => {
  const page = await openMesh(browser, service, plane);
  const triangle = 'v 0 0 0\nv 1 0 0\nv 0 1 0\n';
  await show(page, 'alone.obj', `${triangle}f 1 2 3\n`);
  const alone = await settled(page);
  assert.ok(statistics(alone).still < 0.95, 'the triangle is seen');
  await show(page, 'far.obj', `${triangle}v 1e6 -1e7 1e8\nf 1 2 3\n`);
  assert.ok(difference(alone, await settled(page)) < 0.001);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('the key for other colours says where there are none', async () => {
  const page = await openMesh(browser, service, plane, '&from=9700,0.3,0.3&from=300,0.3,0.3&show=regions');
  await page.waitForSelector('.legend:not([hidden])');
  await page.keyboard.press('c');
  await until(async () => /choose Distance/.test(await page.locator('.hint').textContent()), 'the hint');
  assert.ok(!page.url().includes('colours='));
  await page.context().close();
});

test('a path that is not the answer any more is faded until the next has come', async () => {
  const page = await openMesh(browser, service, plane);
  await page.mouse.click(250, 330);
  await page.mouse.click(620, 430);
  await until(async () => /\d/.test(await page.textContent('#length')), 'a path');
  let go;
  const held = new Promise((resolve) => { go = resolve; });
  await page.route('**/path?**', async (route) => {
    await held;
    await route.continue();
  });
  await page.mouse.click(420, 250);
  await page.waitForSelector('.result.stale');
  await picture(page, '63-faded');
  go();
  await page.waitForSelector('.result:not(.stale)');
  await picture(page, '64-not-faded');
  assert.deepEqual(page.faults, []);
  await page.context().close();
});
