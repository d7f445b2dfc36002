// A large mesh is seen while its faces still come.
import assert from 'node:assert/strict';
import { Readable } from 'node:stream';
import { test } from 'node:test';
import { newPage, picture, ready, until } from './browser.mjs';
import { statistics } from './pixels.mjs';
import { proxied } from './proxy.mjs';
import { served } from './served.mjs';
import { wavyMesh } from './wavy_mesh.mjs';

const { browser, service } = await served();
const FACES = 2 * 399 * 399;
const upload = async (body) => (await (await fetch(`${service.url}v1/meshes`, { method: 'POST', body })).json()).id;
const mesh = await upload(wavyMesh(400));

/** Lets so much of each geometry through, and the rest once it is told to. */
function halting(share) {
  let goOn;
  const told = new Promise((resolve) => { goOn = resolve; });
  const through = (target, reply) => {
    if (!target.includes(`${mesh}/geometry`)) return reply;
    return Readable.from((async function* () {
      let left = share * Number(reply.headers['content-length']);
      for await (const piece of reply) {
        if (left < piece.length) await told;
        left -= piece.length;
        yield piece;
      }
    })());
  };
  return { through, goOn };
}

for (const [name, options] of [['light', {}], ['dark', { colorScheme: 'dark' }]]) {
  test(`the first picture comes before the last byte: ${name}`, async () => {
    const { through, goOn } = halting(0.8);
    const proxy = await proxied(service, { through });
    const page = await newPage(browser, options);
    await page.goto(`${proxy.url}#mesh=${mesh}`);
    await until(async () => Number(await page.getAttribute('body', 'data-preview')) > 0.3 * FACES, 'faces');
    assert.equal(await page.getAttribute('body', 'data-state'), 'loading');
    const early = statistics(await picture(page, `78-arriving-${name}`));
    assert.ok(early.colours > 10, `${early.colours} colours`);
    // What cannot be picked yet is not.
    await page.mouse.click(430, 380);
    assert.equal(await page.locator('.point').count(), 0);
    goOn();
    await ready(page);
    assert.equal(await page.getAttribute('body', 'data-preview'), null);
    await page.mouse.click(430, 380);
    await until(async () => (await page.locator('.point').count()) === 1, 'the point');
    assert.deepEqual(page.faults, []);
    await page.context().close();
  });
}

test('a mesh that is chosen meanwhile is shown instead', async () => {
  const { through } = halting(0.8);
  const proxy = await proxied(service, { through });
  const small = await upload(wavyMesh(20));
  const page = await newPage(browser);
  await page.goto(`${proxy.url}#mesh=${mesh}`);
  await until(async () => Number(await page.getAttribute('body', 'data-preview')) > 0, 'faces');
  await page.evaluate((id) => { location.hash = `mesh=${id}`; }, small);
  await ready(page);
  assert.equal(await page.getAttribute('body', 'data-preview'), null);
  assert.match(await page.textContent('.panel'), /400 vertices/);
  assert.deepEqual(page.faults, []);
  await page.context().close();
});

test('a mesh that breaks off is fetched again', async () => {
  let tries = 0;
  const proxy = await proxied(service, {
    through: (target, reply) => (!target.includes(`${mesh}/geometry`) || ++tries > 1 ? reply : Readable.from((async function* () {
      let left = 0.8 * Number(reply.headers['content-length']);
      for await (const piece of reply) {
        if ((left -= piece.length) < 0) throw new Error('the network is gone');
        yield piece;
      }
    })())),
  });
  const page = await newPage(browser);
  await page.goto(`${proxy.url}#mesh=${mesh}`);
  await ready(page);
  assert.equal(tries, 2);
  assert.equal(await page.getAttribute('body', 'data-preview'), null);
  await page.mouse.click(430, 380);
  await until(async () => (await page.locator('.point').count()) === 1, 'the point');
  await page.context().close();
});
