/** Queries about a part of a surface. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient, type Region, type Source } from 'geodesicd-client';
import { fixture, watchedFetch } from './fixture.js';

const { server, client, plane } = await fixture();
const seen: string[] = [];
const watched = new GeodesicClient(server.url, { fetch: watchedFetch(seen) });
const base = `/v1/meshes/${plane}`;

async function requestOf(forbid: Region | Region[]): Promise<string> {
  seen.length = 0;
  await watched.nearest(plane, { point: 'p:0,0,0', forbid });
  assert.equal(seen.length, 1);
  return seen[0]!;
}

test('regions go by GET where a URL can say them', async () => {
  const said: [Region, string][] = [
    ['faces:7', 'faces:7'],
    [{ faces: [7, [10, 99]] }, 'faces:7,10-99'],
    [{ sphere: { center: [1, 2, 3], radius: 0.5 } }, 'sphere:1,2,3,0.5'],
    [{ box: { min: [1, 2, 0], max: [4, 5, 6] } }, 'box:1,2,0,4,5,6'],
  ];
  for (const [region, text] of said) {
    assert.equal(await requestOf(region), `GET ${base}/nearest?point=p:0,0,0&forbid=${text}`);
  }
  assert.equal(
    await requestOf(['faces:7', { faces: [8] }]),
    `GET ${base}/nearest?point=p:0,0,0&forbid=faces:7&forbid=faces:8`,
  );
  const many = { faces: Array.from({ length: 900 }, (_, k) => 2 * k) };
  assert.equal(await requestOf(many), `POST ${base}/nearest`);
  const path = await client.path(plane, { from: 0, to: 1, within: { part: 0 } });
  assert.equal(path.length, 1);
});

test('materials and parts are regions by name, whatever is in it', async () => {
  const names = ['glass & steel+50%', '3', 'none', '"quoted"', 'ä#?=;,*', ''];
  const text = ['v 0 0 0', 'v 1 0 0', 'v 0 1 0', 'v 1 1 0', 'o roof'];
  for (const name of names) text.push(`usemtl ${name}`, 'f 1 2 3', 'f 2 4 3');
  const mesh = await client.upload(new TextEncoder().encode(text.join('\n')));
  assert.deepEqual(mesh.materials?.map(({ name }) => name), names.slice(0, -1));
  assert.deepEqual(mesh.materials?.map(({ face_count }) => face_count), [2, 2, 2, 2, 2]);
  const reached = async (within: Region) => (await client.distance(mesh.id, { from: 0, within })).reached;
  for (const [place, name] of names.slice(0, -1).entries()) {
    for (const region of [{ material: name }, { material: place }, `material:"${name}"`]) {
      assert.equal(await reached(region), 4);
      await assert.rejects(
        client.distance(mesh.id, { from: 0, within: region, forbid: { faces: [[2 * place, 2 * place + 1]] } }),
        { code: 'value_out_of_range', parameter: 'forbid' },
      );
    }
  }
  assert.equal(await reached({ material: null }), 4);
  assert.equal(await reached({ part: 'roof' }), 4);
  const from = await client.distance(mesh.id, { from: { material: '3' }, method: 'exact' });
  assert.deepEqual([...from.values], [0, 0, 0, 0]);
  const costly = await client.distancesAt(mesh.id, {
    from: 0,
    at: 1,
    weights: names.map((name) => ({ weight: 2, region: { material: name === '' ? null : name } })),
  });
  assert.equal(costly.distances[0], 2);
  await assert.rejects(reached({ part: '0' }), { code: 'value_out_of_range', parameter: 'within.part' });
  await assert.rejects(reached({ material: 'glass' }), { code: 'value_out_of_range', parameter: 'within.material' });
});

test('what is forbidden is gone round', async () => {
  const forbid = { box: { min: [20, 20, -1], max: [80, 80, 1] } } as const;
  const path = await client.path(plane, { from: 0, to: 9999, method: 'exact', forbid });
  const expected = Math.hypot(80, 20) + Math.hypot(19, 79);
  assert.ok(Math.abs(path.length! - expected) < 1e-9);
  const field = await client.distance(plane, { from: 0, forbid });
  assert.equal(field.values.length, 10_000);
  assert.equal(field.values[5050], Infinity);
  assert.equal(field.reached, 10_000 - 59 * 59);
  for await (const answer of client.batch(plane, [
    { query: 'path', from: 0, to: 9999, method: 'exact', forbid },
  ])) {
    assert.ok(answer.ok && Math.abs(answer.reply.length! - expected) < 1e-9);
  }
});

test('labels are regions, as a text and as an object', async () => {
  const from = [0, 9999];
  const file = await client.annotated(plane, { of: 'distance', from, labels: true });
  const mesh = await client.upload(file);
  for (const value of [0, 1]) {
    const label = { label: { attribute: '_GEODESIC_SOURCE', value } };
    const within = await client.distance(mesh.id, { from: from[value]!, within: label });
    assert.ok(within.reached! > 1000 && within.reached! < 9000);
    const text = await client.distance(mesh.id, {
      from: from[value]!,
      within: `label:_GEODESIC_SOURCE=${value}`,
    });
    assert.deepEqual(text.values, within.values);
  }
  await assert.rejects(client.distance(mesh.id, { from: 0, forbid: { label: { attribute: '_SEG', value: 1 } } }), {
    code: 'value_out_of_range',
    parameter: 'forbid.label',
  });
});

test('regions that are none are refused by the server', async () => {
  const refused = (forbid: unknown, code: string, parameter: string) =>
    assert.rejects(client.samples(plane, { count: 1, forbid: forbid as Region }), { code, parameter });
  await refused([], 'value_out_of_range', 'forbid');
  await refused({ part: 0 }, 'value_out_of_range', 'forbid');
  await refused({ part: 1 }, 'index_out_of_range', 'forbid.part');
  await refused({ ball: 1 }, 'bad_syntax', 'forbid');
  await refused({ sphere: { center: [0, 0], radius: 1 } }, 'bad_syntax', 'forbid.sphere.center');
  await refused({ sphere: { center: [0, 0, 0], radius: 1, x: 1 } }, 'unknown_parameter', 'forbid.sphere.x');
  await refused({ faces: [[9, 3]] }, 'value_out_of_range', 'forbid.faces[0]');
  await assert.rejects(client.path(plane, { from: 0, to: 9999, within: 'faces:0-9' }), {
    code: 'outside_region',
    parameter: 'to',
  });
});

test('walls are gone round, and insides are regions', async () => {
  const points = ['p:50.3,10.2,0', 'p:50.3,80.6,0'];
  const expected = Math.hypot(20.3, 20.6) + Math.hypot(19.7, 20.6);
  const ask = { from: 'p:30,60,0', to: 'p:70,60,0', method: 'exact' } as const;
  seen.length = 0;
  for (const walls of [{ points }, points.join(';'), [{ points: [...points, { xyz: [50.3, 80.6, 0], max_snap: 1 }] as Source[] }]]) {
    const path = await watched.path(plane, { ...ask, walls });
    assert.ok(Math.abs(path.length! - expected) < 1e-9);
  }
  assert.equal(
    seen[0],
    `GET ${base}/path?from=p:30,60,0&to=p:70,60,0&method=exact&walls=${points.join(';')}`,
  );
  assert.equal(seen[2], `POST ${base}/path`);
  const inside = [2020, 2060, 6060, 6020];
  const measured = await client.measure(plane, { from: 'p:40,40,0', within: { inside } });
  assert.ok(Math.abs(measured.area! - 1600) < 1e-6);
  for await (const answer of client.batch(plane, [
    { query: 'measure', from: 0, forbid: { inside } },
  ])) {
    assert.ok(answer.ok && Math.abs(answer.reply.area! - (99 * 99 - 1600)) < 1e-6);
  }
  await assert.rejects(client.path(plane, { from: 0, to: 1, walls: { points: [5] } }), {
    code: 'value_out_of_range',
    parameter: 'walls',
  });
  await assert.rejects(client.path(plane, { from: 0, to: 1, walls: { points: [5, 99999] } }), {
    code: 'index_out_of_range',
    parameter: 'walls.points[1]',
  });
});
