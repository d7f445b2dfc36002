/** What is sent: GET that caches can keep where it fits, JSON where not; and the client's making. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient, type Source } from 'geodesicd-client';
import { fixture, watchedFetch } from './fixture.js';

const { server, client, plane } = await fixture();
const seen: string[] = [];
const watched = new GeodesicClient(server.url, { fetch: watchedFetch(seen) });
const base = `/v1/meshes/${plane}`;

async function requestOf(from: Source | Source[]): Promise<string> {
  seen.length = 0;
  await watched.distancesAt(plane, { from, at: 1 });
  assert.equal(seen.length, 1);
  return seen[0]!;
}

test('what the grammar of URLs can say goes by GET', async () => {
  const said: [Source, string][] = [
    [7, 'v:7'],
    ['v:7', 'v:7'],
    [{ vertex: 7 }, 'v:7'],
    [{ face: 40, bary: [0.25, 0.25, 0.5] }, 'f:40,0.25,0.25'],
    [{ xyz: [1, 2, 3e-21] }, 'p:1,2,3e-21'],
    [{ xyz: [1, 2, 1e21] }, 'p:1,2,1e%2B21'],
    [{ ray: { origin: [3, 4, 9], direction: [0, 0, -1] } }, 'ray:3,4,9,0,0,-1'],
  ];
  for (const [point, text] of said) {
    assert.equal(await requestOf(point), `GET ${base}/distance?from=${text}&at=v:1`);
  }
  assert.equal(await requestOf([1, 2]), `GET ${base}/distance?from=v:1&from=v:2&at=v:1`);
});

test('what it cannot say goes by POST, with the same answer', async () => {
  assert.equal(await requestOf({ vertex: 7, offset: 2 }), `POST ${base}/distance`);
  assert.equal(await requestOf({ xyz: [1, 2, 3], max_snap: 9 }), `POST ${base}/distance`);
  seen.length = 0;
  const many = Array.from({ length: 500 }, (_, vertex) => vertex);
  const { distances } = await watched.distancesAt(plane, { from: 0, at: many });
  assert.deepEqual(seen, [`POST ${base}/distance`]);
  assert.equal(distances.length, 500);
  const short = await client.distance(plane, { from: 7 }, { values: 'f64' });
  const long = await client.distance(plane, { from: [{ vertex: 7, offset: 0 }] }, { values: 'f64' });
  assert.deepEqual(long.values, short.values);
});

test('weights that do not add up are refused, not mended', async () => {
  const from = { face: 0, bary: [0.5, 0.1, 0.1] as const };
  await assert.rejects(client.distance(plane, { from }), { code: 'value_out_of_range' });
});

test('a field is float32, or float64 on demand, and equal to the bare arrays', async () => {
  const single = await client.distance(plane, { from: [0, 99], labels: true });
  const double = await client.distance(plane, { from: [0, 99] }, { values: 'f64' });
  assert.ok(single.values instanceof Float32Array && double.values instanceof Float64Array);
  assert.deepEqual(single.values, new Float32Array(double.values));
  assert.deepEqual(single.labels!.slice(98, 100), new Uint32Array([1, 1]));
  assert.equal(double.labels, undefined);
  const bare = await client.array(plane, { of: 'distance', from: [0, 99], format: 'f32' });
  assert.deepEqual(bare.data, single.values);
  assert.equal(single.cache, 'miss');
  assert.equal(double.cache, 'hit');
  assert.ok((single.timing.solve ?? 0) > 0);
  const geometry = await client.geometry(plane);
  assert.ok(geometry.positions instanceof Float32Array);
  assert.equal(geometry.positions.length, 3 * single.values.length);
});

test('no points are not all points', async () => {
  await assert.rejects(client.distancesAt(plane, { from: 0, at: [] }), RangeError);
});

test('an id is never a path of its own', async () => {
  for (const id of ['../status', 'a/b']) {
    await assert.rejects(client.mesh(id), { status: 400, code: 'bad_syntax' });
  }
});

test('pages are fetched as they are needed', async () => {
  const { id } = await client.upload(new TextEncoder().encode(TRIANGLE));
  seen.length = 0;
  const ids = [];
  for await (const mesh of watched.meshes({ limit: 1 })) ids.push(mesh.id);
  assert.deepEqual(ids, [plane, id].sort());
  assert.equal(seen.length, 2);
  seen.length = 0;
  for await (const _ of watched.meshes({ limit: 1 })) break;
  assert.equal(seen.length, 1);
  await client.deleteMesh(id);
});

test('an address may end in a slash, have a path, and must be one', async () => {
  assert.equal((await new GeodesicClient(`${server.url}/`).status()).name, 'geodesicd');
  const below = new GeodesicClient(`${server.url}/below?x#y`, { fetch: watchedFetch(seen) });
  seen.length = 0;
  await assert.rejects(below.status(), { code: 'route_unknown' });
  assert.deepEqual(seen, ['GET /below/v1/status']);
  assert.throws(() => new GeodesicClient('no address'), TypeError);
  assert.throws(() => new GeodesicClient(), TypeError);
});

test('a token that no header can carry is an error of its own, not a lost connection', async () => {
  const pasted = new GeodesicClient(server.url, { token: 'abc\u200b' });
  await assert.rejects(pasted.status(), { name: 'TypeError', message: /token.*no header/ });
  const file = new TextEncoder().encode(TRIANGLE);
  await assert.rejects(pasted.upload(file, { onProgress: () => {} }), { name: 'TypeError', message: /token/ });
});

const POSITIONS = Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer);
const TRIANGLE = JSON.stringify({
  asset: { version: '2.0' },
  scenes: [{ nodes: [0] }],
  scene: 0,
  nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
  accessors: [
    { bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 0] },
  ],
  bufferViews: [{ buffer: 0, byteLength: 36 }],
  buffers: [
    { byteLength: 36, uri: `data:application/octet-stream;base64,${POSITIONS.toString('base64')}` },
  ],
});
