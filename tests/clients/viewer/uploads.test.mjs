// Uploads when something is in their way: the network, another choice, a broken file beside
// them, private files in their folder, a part of the page that does not load.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drop, openMesh, ready, until } from './browser.mjs';
import { served } from './served.mjs';
import { wavyObj } from './wavy_mesh.mjs';

const { browser, service } = await served();
const plane = await service.sample('plane');
const sphere = await service.sample('sphere');

const listed = async (name) => (await service.json('/v1/meshes?limit=1000')).meshes.some((mesh) => mesh.name === name);
const chosen = (page) => page.locator('#mesh option:checked').textContent();

test('an upload that the network swallows is told by the name of its file', async () => {
  const page = await openMesh(browser, service, plane);
  await page.route(/\/v1\/meshes\?/, (route) => (route.request().method() === 'POST' ? route.abort('connectionreset') : route.continue()));
  await drop(page, 'lost.obj', wavyObj(15), 'gone.obj', wavyObj(16));
  await page.locator('.trouble', { hasText: 'lost.obj was not uploaded · gone.obj was not uploaded' }).waitFor();
  await page.context().close();
});

test('a broken file is told, although a good one follows', async () => {
  const page = await openMesh(browser, service, plane);
  await drop(page, 'broken.obj', 'f 1 2 3\n', 'worse.obj', 'f 4 5 6\n', 'good.obj', wavyObj(17), 'last.obj', 'f 7 8 9\n');
  await until(async () => (await chosen(page)) === 'good.obj', 'the good one');
  await ready(page);
  await page.locator('.trouble', { hasText: /broken\.obj.*worse\.obj.*last\.obj/ }).waitFor();
  await page.context().close();
});

test('whoever chooses another mesh meanwhile gets all of the files all the same', async () => {
  const page = await openMesh(browser, service, plane);
  // The first file's hierarchy is never finished: its worker's script waits.
  let waits = 0;
  await page.route(/bvh_worker/, (route) => { if (waits++) return route.continue(); });
  await drop(page, 'first.obj', wavyObj(22), 'second.obj', wavyObj(23), 'third.obj', wavyObj(24));
  await until(() => waits, 'the first file on show');
  await page.selectOption('#mesh', sphere);
  await ready(page);
  for (const name of ['first.obj', 'second.obj', 'third.obj']) await until(() => listed(name), name);
  assert.match(await chosen(page), /^sphere/);
  await page.context().close();
});

test('a worker that does not load is told, with the way out', async () => {
  const page = await openMesh(browser, service, plane);
  await page.route(/bvh_worker/, (route) => route.fulfill({ status: 404, body: '' }));
  await page.selectOption('#mesh', sphere);
  await page.locator('.trouble', { hasText: 'reload this page' }).waitFor();
  await ready(page, 'failed');
  await page.unroute(/bvh_worker/);
  await page.getByRole('button', { name: 'Reload' }).click();
  await ready(page);
  assert.match(await chosen(page), /^sphere/);
  await page.context().close();
});

/** A glTF of one triangle whose buffer is a file beside it. */
const gltf = (uri) => JSON.stringify({
  asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
  buffers: [{ byteLength: 36, uri }], bufferViews: [{ buffer: 0, byteLength: 36 }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [3, 4, 0] }],
});
const buffer = (x) => Buffer.from(new Float32Array([0, 0, 0, x, 0, 0, 0, 4, 0]).buffer);

test('a glTF takes the files of its buffers along, and nothing else that lies there', async () => {
  const page = await openMesh(browser, service, plane);
  await page.evaluate(() => {
    window.sent = '';
    const send = XMLHttpRequest.prototype.send;
    XMLHttpRequest.prototype.send = function (body) {
      if (!(body instanceof Blob)) return send.call(this, body);
      body.text().then((text) => { window.sent += text; send.call(this, body); });
    };
  });
  const forms = [['the scene.bin', 'the%20scene.bin'], ['100%.bin', './100%.bin'], ['bare.bin', 'data/bare.bin']];
  for (const [index, [name, uri]] of forms.entries()) {
    const called = `scene${index}.gltf`;
    await drop(page, name, buffer(3 + index), called, gltf(uri), '.env', 'API_KEY=hunter2', 'notes.txt', 'dear diary');
    await until(async () => (await chosen(page)) === called, called);
    await ready(page);
  }
  const sent = await page.evaluate(() => window.sent);
  for (const [name] of forms) assert.ok(sent.includes(`filename="${name}"`), name);
  assert.ok(!/hunter2|dear diary/.test(sent), 'nothing private');
  assert.equal(await page.locator('.trouble').count(), 0);
  await page.context().close();
});

test('a mesh without a name has none after it was read again', async () => {
  const { id } = await service.json('/v1/meshes', { method: 'POST', body: wavyObj(33) });
  const page = await openMesh(browser, service, id);
  // An upload reads the file for its digest again and then names the mesh: its first step tells.
  await page.evaluate(() => {
    window.reads = window.digests = 0;
    const read = Blob.prototype.arrayBuffer;
    Blob.prototype.arrayBuffer = function () { window.reads++; return read.call(this); };
    const digest = crypto.subtle.digest.bind(crypto.subtle);
    crypto.subtle.digest = (...given) => digest(...given).finally(() => setTimeout(() => { window.digests++; }));
  });
  await page.getByText('Import options').click();
  await page.getByRole('button', { name: 'Read this mesh again' }).click();
  await until(() => page.evaluate(() => window.digests), 'the digest of the file');
  assert.equal(await page.evaluate(() => window.reads), 1, 'the server has it');
  assert.equal((await service.json(`/v1/meshes/${id}`)).name, undefined);
  await page.context().close();
});
