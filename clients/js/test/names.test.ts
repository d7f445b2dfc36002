/** Names of meshes: a file brings its own, an option says another, and a mesh can be renamed. */
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { GeodesicClient } from 'geodesicd-client';
import { readCases } from './case_table.js';
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

const { refused, taken, rows } = readCases().file_names;
const cleaned: [name: string, kept: string | null][] = [
  ...rows,
  [`a${refused}b.glb`, 'ab.glb'],
  [`a${taken}.glb`, `a${taken}.glb`],
  ['scans/2024\\ball.glb', 'ball.glb'],
  ['scans/', null],
];
for (const [name, kept] of cleaned) {
  for (const digest of [true, false]) {
    const what = `${JSON.stringify(name).slice(0, 40)}, ${digest ? 'digest' : 'bytes'} first`;
    test(`no upload fails for a file's name: ${what}`, { skip }, async () => {
      assert.equal((await client.upload(file(name), { digest })).name ?? null, kept);
    });
  }
}

test('a mesh that is there gets what is left of a file’s name', { skip: skip || !globalThis.crypto }, async () => {
  const { id } = await client.upload(sphere);
  for (const [name, kept] of cleaned) {
    await client.renameMesh(id, '');
    assert.equal((await client.upload(file(name))).name ?? null, kept);
    if (kept !== null) assert.equal((await client.mesh(id)).name, kept);
  }
});

test('the server refuses what the table of names says, and takes the rest', async () => {
  const { id } = await client.upload(sphere);
  for (const character of refused) {
    await assert.rejects(client.renameMesh(id, `a${character}b`), { status: 400, parameter: 'name' }, JSON.stringify(character));
  }
  for (const character of taken) {
    assert.equal((await client.renameMesh(id, `a${character}b`)).name, `a${character}b`);
  }
});

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

const NO_NAMING: Record<string, () => Promise<Response>> = {
  'is forbidden': async () => new Response('{"code": "forbidden", "status": 403, "title": "no"}', { status: 403 }),
  'is refused': async () => new Response('', { status: 400 }),
  'comes too late': async () => new Response('', { status: 404 }),
  'fails in the server': async () => new Response('', { status: 500 }),
  'cannot be stored': async () => new Response('', { status: 507 }),
  'is too much now': async () => new Response('', { status: 503 }),
  'is answered by what is between': async () => new Response('<html>'),
  'loses the connection': async () => Promise.reject(new TypeError('fetch failed')),
};
for (const [what, answer] of Object.entries(NO_NAMING)) {
  test(`an upload whose naming ${what} fails only where the name was asked for`, { skip: skip || !globalThis.crypto }, async () => {
    const { id } = await client.upload(sphere);
    const unnamed = new GeodesicClient(server.url, {
      retries: 0,
      fetch: (input, init) => (init?.method === 'PATCH' ? answer() : fetch(input, init)),
    });
    const mesh = await unnamed.upload(file('first.glb'));
    assert.deepEqual([mesh.id, mesh.name], [id, undefined]);
    assert.equal((await unnamed.uploadJob(file('first.glb'))).id, id);
    await assert.rejects(unnamed.upload(sphere, { name: 'first' }));
    await assert.rejects(unnamed.upload(file('first.glb'), { name: 'first' }));
  });
}

test('an abort ends an upload that is about to name its mesh', { skip: skip || !globalThis.crypto }, async () => {
  await client.upload(sphere);
  const ended = new AbortController();
  const aborting = new GeodesicClient(server.url, {
    fetch: (input, init) => {
      if (init?.method === 'PATCH') ended.abort();
      return fetch(input, init);
    },
  });
  await assert.rejects(aborting.upload(file('first.glb'), { signal: ended.signal }), { name: 'AbortError' });
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
