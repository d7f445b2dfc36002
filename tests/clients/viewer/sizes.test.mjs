// Meshes in any unit: what is seen does not depend on it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openMesh, picture, textAt } from './browser.mjs';
import { difference, statistics } from './pixels.mjs';
import { served } from './served.mjs';
import { wavyObj } from './wavy_mesh.mjs';

const { browser, service } = await served();

const scaled = (obj, by) =>
  obj.replace(/^v (.*)$/gm, (_, numbers) => `v ${numbers.split(' ').map((number) => Number(number) * by).join(' ')}`);

async function seen(by, more) {
  const { id } = await service.json(`/v1/meshes?name=unit${by}.obj`, { method: 'POST', body: scaled(wavyObj(30), by) });
  const page = await openMesh(browser, service, id, `&ticks=0&from=400,0.3,0.3${more}`, { reducedMotion: 'reduce' });
  await textAt(page, '.legend', (text) => /\d/.test(text));
  const png = await picture(page, `sizes-${by}`);
  assert.deepEqual(page.faults, []);
  await page.context().close();
  return png;
}

for (const [what, more] of [['distances', ''], ['regions', '&from=1500,0.3,0.3&show=regions']]) {
  test(`${what} on meshes of 1e31 and of 1e-29 units are painted as those of 30`, async () => {
    const usual = await seen(1, more);
    assert.ok(statistics(usual).colourful > 0.05);
    for (const by of [1e30, 1e-30]) {
      const share = difference(usual, await seen(by, more));
      assert.ok(share < 0.005, `${by}: ${share} of the picture is another`);
    }
  });
}
