/** Cheap ways instead of short ones. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient, type WeightedRegion } from 'geodesicd-client';
import { fixture, watchedFetch } from './fixture.js';

const { server, client, plane } = await fixture();
const seen: string[] = [];
const watched = new GeodesicClient(server.url, { fetch: watchedFetch(seen) });
const base = `/v1/meshes/${plane}`;
const near = (a: number | null | undefined, b: number) => assert.ok(Math.abs(a! - b) < 1e-6 * b, `${a} is not ${b}`);

test('costs go by GET where a URL can say them', async () => {
  const ends = { from: 0, to: 99 };
  const asked = async (more: object) => {
    seen.length = 0;
    const path = await watched.path(plane, { ...ends, ...more });
    assert.equal(seen.length, 1);
    return [decodeURIComponent(seen[0]!), path] as const;
  };
  const start = `GET ${base}/path?from=v:0&to=v:99`;
  const [weights, path] = await asked({ weights: { weight: 2, region: { faces: [[0, 19601]] } } });
  assert.equal(weights, `${start}&weights=2*faces:0-19601`);
  near(path.cost, 2 * 99);
  assert.equal(path.unit, 'length');
  assert.equal(path.segments!.length + 1, path.points.length);
  const [slope, climb] = await asked({ slope: [[-1, 2], [1, 4]], up: [1, 0, 0] });
  assert.equal(slope, `${start}&slope=-1:2,1:4&up=1,0,0`);
  near(climb.cost, 4 * 99);
  assert.equal(climb.unit, 'cost');
  const [posted] = await asked({ face_weights: Array.from({ length: 19602 }, () => 1) });
  assert.equal(posted, `POST ${base}/path`);
  assert.equal((await client.path(plane, ends)).cost, undefined);
});

test('fields, tables and isolines are of costs', async () => {
  const up = { slope: '-1:2,1:4', up: '1,0,0' };
  const field = await client.distance(plane, { from: 0, ...up });
  near(field.values[99], 4 * 99);
  assert.equal(field.unit, 'cost');
  assert.equal((await client.distance(plane, { from: 0 })).unit, undefined);
  near((await client.distancesAt(plane, { from: 99, at: 0, ...up })).distances[0], 2 * 99);
  const table = await client.table(plane, { from: [0, 99], ...up });
  near(table.distances[1], 4 * 99);
  near(table.distances[2], 2 * 99);
  assert.equal(table.unit, 'cost');
  assert.equal((await client.isolines(plane, { from: 0, step: 100, ...up })).unit, 'cost');
});

test('costs that are none are refused by the server', async () => {
  const refused = (weights: unknown, code: string, parameter: string) =>
    assert.rejects(client.path(plane, { from: 0, to: 9, weights: weights as WeightedRegion[] }), { code, parameter });
  await refused([{ weight: 2 }], 'bad_syntax', 'weights[0]');
  await refused(['2'], 'bad_syntax', 'weights[0]');
  await refused([{ weight: -1, region: 'faces:0' }], 'value_out_of_range', 'weights[0].weight');
  await refused(['2*faces:0', { weight: 2, region: { part: 1 } }], 'index_out_of_range', 'weights[1].part');
  await assert.rejects(client.path(plane, { from: 0, to: 9, slope: [] }), { code: 'bad_syntax', parameter: 'slope' });
  await assert.rejects(client.path(plane, { from: 0, to: 9, slope: 'tobler', method: 'exact' }), {
    code: 'value_out_of_range',
    parameter: 'method',
  });
});
