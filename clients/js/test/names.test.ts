/** Names of meshes: a file brings its own, an option says another, and a mesh can be renamed. */
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { GeodesicClient } from 'geodesicd-client';
import { fixture, watchedFetch } from './fixture.js';
import { sample } from './server.js';

const { server, client } = await fixture();
const seen: string[] = [];
const watched = new GeodesicClient(server.url, { fetch: watchedFetch(seen) });
const sphere = sample('sphere.glb');
// Node 18 has no File of its own.
const skip = globalThis.File ? false : 'this platform has no File';
const file = (name: string) => new File([sphere], name);

/** The server forgets the sphere. */
beforeEach(async () => {
  for await (const mesh of client.meshes()) {
    if (mesh.bytes === sphere.length) await client.deleteMesh(mesh.id);
  }
  seen.length = 0;
});

test('bytes have no name unless one is said', async () => {
  assert.equal((await client.upload(sphere)).name, undefined);
});

for (const digest of [true, false]) {
  for (const way of ['upload', 'uploadJob'] as const) {
    test(`a file brings its name along: ${way}, ${digest ? 'digest' : 'bytes'} first`, { skip }, async () => {
      const name = 'größe & form + 100 %;"x" 球.glb';
      const mesh = await client[way](file(name), { digest });
      assert.equal(mesh.name, name);
      assert.equal((await client.mesh(mesh.id)).name, name);
    });
  }
}

test('an option says another name, of bytes too', { skip }, async () => {
  assert.equal((await client.upload(sphere, { name: 'ball' })).name, 'ball');
  const other = await client.upload(file('a.glb'), { name: 'ball in mm', reading: { scale: 0.001 } });
  assert.equal(other.name, 'ball in mm');
});

test('an empty name in the option leaves a file without one', { skip }, async () => {
  assert.equal((await client.upload(file('a.glb'), { name: '' })).name, undefined);
});

for (const [what, name, kept] of [
  ['a folder', 'scans/2024\\ball.glb', 'ball.glb'],
  ['control characters', 'ba\u0007l\nl\u0085.glb', 'ball.glb'],
  ['spaces around it', '  ball.glb ', 'ball.glb'],
  ['201 bytes', `x${'a'.repeat(196)}.glb`, `${'a'.repeat(196)}.glb`],
  ['200 bytes and more in characters of 4', `${'😀'.repeat(60)}.glb`, `${'😀'.repeat(49)}.glb`],
  ['nothing but a folder', 'scans/', undefined],
] as const) {
  test(`a file's name with ${what} is cut to what the server takes`, { skip }, async () => {
    assert.equal((await client.upload(file(name))).name, kept);
  });
}

test('a name that is said and not allowed is refused', async () => {
  for (const name of ['a\nb', 'x'.repeat(201)]) {
    await assert.rejects(client.upload(sphere, { name, digest: false }), { status: 400 });
    await assert.rejects(client.upload(sphere, { name }), { status: 400 });
  }
});

test('a mesh that is there keeps its name; one without gets the file’s', { skip: skip || !globalThis.crypto }, async () => {
  const { id } = await client.upload(sphere);
  assert.equal((await watched.upload(file('first.glb'))).name, 'first.glb');
  assert.deepEqual(seen, [`HEAD /v1/meshes/${id}`, `GET /v1/meshes/${id}`, `PATCH /v1/meshes/${id}`]);
  seen.length = 0;
  assert.equal((await watched.upload(file('second.glb'))).name, 'first.glb');
  assert.deepEqual(seen, [`HEAD /v1/meshes/${id}`, `GET /v1/meshes/${id}`]);
  const refused = client.renameMesh(id, 'a\tb');
  await assert.rejects(refused, { status: 400 });
});

test('who may not name a mesh still gets it, unless the name was asked for', { skip: skip || !globalThis.crypto }, async () => {
  const { id } = await client.upload(sphere);
  const refusing: typeof fetch = (input, init) =>
    init?.method === 'PATCH'
      ? Promise.resolve(new Response('{"code": "forbidden", "status": 403, "title": "no"}', { status: 403 }))
      : fetch(input, init);
  const reader = new GeodesicClient(server.url, { fetch: refusing });
  assert.equal((await reader.upload(file('first.glb'))).id, id);
  await assert.rejects(reader.upload(sphere, { name: 'first' }), { status: 403 });
});

test('a mesh is renamed, and its name is taken away', async () => {
  const { id } = await client.upload(sphere, { name: 'ball' });
  assert.equal((await client.renameMesh(id, 'Erde 🌍')).name, 'Erde 🌍');
  assert.equal((await client.mesh(id)).name, 'Erde 🌍');
  assert.equal((await client.renameMesh(id, '')).name, undefined);
  await assert.rejects(client.renameMesh('0'.repeat(64), 'x'), { code: 'mesh_unknown' });
});

test('a glTF with its buffers is called by the name of the glTF, without what no text may have', async () => {
  const corners = new Uint8Array(new Float32Array([0, 0, 0, 3, 0, 0, 0, 4, 0]).buffer);
  const gltf = JSON.stringify({
    asset: { version: '2.0' }, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    buffers: [{ byteLength: 36, uri: 'corners.bin' }], bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [3, 4, 0] }],
  });
  const files = [{ name: 'corners.bin', data: corners }, { name: 'shop/tri\ud800angle.gltf', data: new TextEncoder().encode(gltf) }];
  assert.equal((await client.upload(files)).name, 'triangle.gltf');
});
