// Regions of many sources: those that touch are told apart, by eye and by the shader.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, picture, textAt, until } from './browser.mjs';
import { viewerModule } from './modules.mjs';
import { statistics } from './pixels.mjs';
import { served } from './served.mjs';

const { lookOf } = await viewerModule('regions.ts');
const { oklabOf, colourOf } = await viewerModule('oklab.ts');

/** Numbers from 0 to 1, the same in every run. */
function random(seed) {
  let state = seed;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
}

/** A torus of `side` by `side` quads, or the plane where its edges are not joined. */
function grid(side, joined) {
  const around = joined ? side : side - 1;
  const triangles = [];
  for (let y = 0; y < around; y++) {
    for (let x = 0; x < around; x++) {
      const at = (dx, dy) => ((y + dy) % side) * side + ((x + dx) % side);
      triangles.push(at(0, 0), at(1, 0), at(0, 1), at(1, 0), at(1, 1), at(0, 1));
    }
  }
  return Uint32Array.from(triangles);
}

/** Each vertex by the nearest of some vertices, step by step along the edges. */
function nearestOf(triangles, vertices, count, next) {
  const beside = Array.from({ length: vertices }, () => new Set());
  for (let i = 0; i < triangles.length; i += 3) {
    const face = triangles.slice(i, i + 3);
    for (const one of face) for (const other of face) if (one !== other) beside[one].add(other);
  }
  const labels = new Uint32Array(vertices).fill(0xffffffff);
  const chosen = new Set();
  while (chosen.size < count) chosen.add(Math.floor(next() * vertices));
  let front = [...chosen];
  front.forEach((vertex, label) => { labels[vertex] = label; });
  while (front.length) {
    const reached = [];
    for (const vertex of front) {
      for (const other of beside[vertex]) {
        if (labels[other] !== 0xffffffff) continue;
        labels[other] = labels[vertex];
        reached.push(other);
      }
    }
    front = reached;
  }
  return labels;
}

for (const [shape, joined] of [['a plane', false], ['a torus', true]]) {
  for (const count of [2, 8, 9, 40, 300, 1000]) {
    test(`${count} regions of ${shape}: those in one face have other slots and other colours`, () => {
      const side = 80;
      const triangles = grid(side, joined);
      const labels = nearestOf(triangles, side * side, count, random(7 * count + Number(joined)));
      const { slots, colours } = lookOf(labels, triangles, count);
      assert.deepEqual([slots.length, colours.length], [count, count]);
      let least = Infinity;
      for (let i = 0; i < triangles.length; i += 3) {
        const regions = [...new Set([0, 1, 2].map((corner) => labels[triangles[i + corner]]))];
        assert.equal(new Set(regions.map((region) => slots[region])).size, regions.length, `slots of ${regions}`);
        for (const one of regions) {
          for (const other of regions) {
            if (one >= other) continue;
            const [a, b] = [oklabOf(colours[one]), oklabOf(colours[other])];
            least = Math.min(least, Math.hypot(...a.map((part, k) => part - b[k])));
          }
        }
      }
      assert.ok(slots.every((slot) => slot < 8));
      assert.ok(least >= 0.085, `two that touch are ${least} apart`);
      if (count > 8) assert.ok(new Set(colours).size > Math.min(0.9 * count, 500), 'colours go on');
    });
  }
}

test('regions that no source reaches, and labels that no source has, are no fault', () => {
  const triangles = grid(4, false);
  const labels = new Uint32Array(16).fill(0xffffffff);
  labels.set([3, 12, 500]);
  assert.equal(lookOf(labels, triangles, 20).colours.length, 20);
});

test('colours go to OKLab and back', () => {
  for (const colour of ['#e8835a', '#4f8fd0', '#000000', '#ffffff', '#6cc4c9']) {
    const [l, a, b] = oklabOf(colour);
    assert.equal(colourOf(l, Math.hypot(a, b), (Math.atan2(b, a) * 180) / Math.PI), colour);
  }
  // Red of screens, as the space's author gives it.
  const red = oklabOf('#ff0000');
  [0.628, 0.2249, 0.1258].forEach((part, k) => assert.ok(Math.abs(red[k] - part) < 1e-3));
});

const { browser, service } = await served();

for (const [name, options] of [['light', {}], ['dark', { colorScheme: 'dark' }]]) {
  test(`three hundred sources of a file have their colours on the page: ${name}`, async () => {
    const page = await openMesh(browser, service, await service.sample('plane'), '', options);
    const next = random(11);
    const lines = Array.from({ length: 300 }, () => `${Math.floor(next() * 10000)}`).join('\n');
    const give = (text) => page.locator('input[aria-label="File of sources"]').setInputFiles({ name: 'many.txt', mimeType: 'text/plain', buffer: Buffer.from(text) });
    await give(lines);
    await page.waitForSelector('.legend:not([hidden])');
    await page.getByLabel('Regions').check();
    await textAt(page, '.legend h2', (text) => /^Nearest of \d+$/.test(text));
    const { colours } = statistics(await picture(page, `76-regions-300-${name}`));
    assert.ok(colours > 60, `${colours} colours`);
    // Beside eight, which have theirs as before.
    await give(lines.split('\n').slice(0, 8).join('\n'));
    await until(async () => (await page.textContent('.legend h2')) === 'Nearest source', 'eight sources');
    const eight = statistics(await picture(page, `77-regions-8-${name}`));
    assert.ok(eight.colours < colours);
    assert.deepEqual(page.faults, []);
    await page.context().close();
  });
}
