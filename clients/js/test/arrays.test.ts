/** Meshes that are arrays or three.js geometries, their colours, and the list as an array. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { BoxGeometry, BufferAttribute, BufferGeometry, Color, InterleavedBuffer, InterleavedBufferAttribute, SRGBColorSpace } from 'three';
import { colourAt, NetworkError, plyOf } from 'geodesicd-client';
import { setColours } from 'geodesicd-client/three';
import { fixture } from './fixture.js';

const { client, plane } = await fixture();

test('float64 positions are not rounded, and keep their numbers', async () => {
  const far = 4_500_000.123456789;
  const positions = new Float64Array([far, 0, 0, far + 0.1, 0, 0, far + 0.1, 0.3, 0, far, 0.3, 0]);
  const mesh = await client.upload({ positions, index: new Uint16Array([0, 1, 2, 0, 2, 3]) });
  const there = await client.geometry(mesh.id, { values: 'f64' });
  assert.deepEqual(there.positions, positions);
  assert.deepEqual([...there.triangles], [0, 1, 2, 0, 2, 3]);
  assert.equal((await client.upload({ positions, index: [0, 1, 2, 0, 2, 3] })).id, mesh.id, 'the same mesh');
  const job = await client.uploadJob({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0] });
  assert.equal(job.faces, 1, 'without an index each three vertices are a face');
});

test('a BufferGeometry is a mesh, be it interleaved or without an index', async () => {
  const box = new BoxGeometry(1, 2, 3);
  const mesh = await client.upload(box);
  assert.equal(mesh.vertices, box.getAttribute('position').count);
  const field = await client.distance(mesh.id, { from: 0 });
  assert.equal(field.values.length, 24);
  const flat = await client.upload(box.toNonIndexed());
  assert.deepEqual([flat.vertices, flat.faces, flat.welded_vertices], [36, 12, 8]);
  const woven = new BufferGeometry();
  const buffer = new InterleavedBuffer(new Float32Array([9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0]), 4);
  woven.setAttribute('position', new InterleavedBufferAttribute(buffer, 3, 1));
  const one = await client.upload(woven);
  assert.equal(one.area, 0.5);
});

test('what is no mesh is refused here', async () => {
  await assert.rejects(client.upload('/mesh.glb' as never), /an address is no mesh.*fetch/);
  assert.throws(() => plyOf({ positions: [1, 2] }), /three numbers a vertex/);
  assert.throws(() => plyOf({ positions: [0, 0, 0], index: [0, 0] }), /three corners/);
  assert.throws(() => plyOf({ positions: [0, 0, 0], index: [0, 0, 1] }), /index\[2\] is 1, of 1 vertices/);
  assert.throws(() => plyOf(new BufferGeometry()), /no attribute `position`/);
});

test('colours: the map from 0 to the greatest, grey where unreached', () => {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(9), 3));
  const colour = (vertex: number) => new Color().fromBufferAttribute(geometry.getAttribute('color') as BufferAttribute, vertex);
  const of = (t: number) => {
    const [r, g, b] = colourAt('magma', t);
    return new Color().setRGB(r / 255, g / 255, b / 255, SRGBColorSpace);
  };
  const first = setColours(geometry, new Float32Array([0, 4, Infinity]), { map: 'magma' });
  assert.ok(colour(0).equals(of(0)) || Math.abs(colour(0).r - of(0).r) < 1e-6);
  assert.ok(Math.abs(colour(1).g - of(1).g) < 1e-6);
  assert.equal(colour(2).getHexString(), '9a9a9a');
  const { version } = first;
  assert.equal(setColours(geometry, new Float32Array([0, 4, 8])), first, 'the same buffer again');
  assert.ok(first.version > version);
  // Signed distances have 0 in the middle of the map.
  const signed = setColours(geometry, new Float32Array([-4, 0, 2]), { map: 'magma' });
  const whole = setColours(new BufferGeometry().copy(geometry), new Float32Array([0, 128, 191]), { map: 'magma', max: 255 });
  assert.deepEqual([...signed.array], [...whole.array]);
  assert.throws(() => setColours(geometry, new Float32Array(2)), /2 values for a geometry of 3/);
});

test('the list as an array', async () => {
  assert.ok((await client.list()).some(({ id }) => id === plane));
  assert.equal((await client.list({ limit: 1 })).length, 1);
});

test('on a page, an error without a reply names the flags; elsewhere it does not', () => {
  assert.doesNotMatch(new NetworkError('http://localhost:8080/v1/status', 'failed').message, /cors/);
  Object.defineProperty(globalThis, 'location', { value: { origin: 'http://localhost:5173' }, configurable: true });
  try {
    const { message } = new NetworkError('http://localhost:8080/v1/status', 'failed');
    assert.match(message, /is --cors-origins set for this origin, http:\/\/localhost:5173\?.*--cors-write-origins/);
    assert.doesNotMatch(new NetworkError('http://localhost:5173/v1/status', 'failed').message, /cors/);
  } finally {
    delete (globalThis as { location?: unknown }).location;
  }
});

test('a glTF with a buffer in a folder', async () => {
  const positions = new Float32Array([0, 0, 0, 3, 0, 0, 0, 4, 0]);
  const document = {
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    buffers: [{ byteLength: 36, uri: 'data/scene.bin' }],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [3, 4, 0] }],
  };
  const gltf = { name: 'scene.gltf', data: new TextEncoder().encode(JSON.stringify(document)) };
  const mesh = await client.upload([gltf, { name: 'data/scene.bin', data: new Uint8Array(positions.buffer) }]);
  assert.deepEqual([mesh.format, mesh.faces, mesh.area], ['glb', 1, 6]);
  await assert.rejects(client.upload([gltf]), (error: Error) => /external_uri/.test(error.message));
});
