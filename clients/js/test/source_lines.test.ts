/** Fields from curves, boundaries and whole faces. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient, type GeodesicError, type SourceLines, type TableQuery } from 'geodesicd-client';
import { fixture, watchedFetch } from './fixture.js';

const { server, plane } = await fixture();
const seen: string[] = [];
const client = new GeodesicClient(server.url, { fetch: watchedFetch(seen) });
const base = `/v1/meshes/${plane}`;

test('sources that are no points go by GET where a URL can say them', async () => {
  const said: [SourceLines, string][] = [
    [{ boundary: 'all' }, 'boundary'],
    [{ boundary: 0 }, 'boundary:0'],
    [{ curve: { points: [1, { vertex: 7 }, 'p:1,2,0'] } }, 'curve:v:1;v:7;p:1,2,0'],
    [{ curve: { points: [1, 7, 990], closed: true } }, 'curve:closed;v:1;v:7;v:990'],
    [{ faces: [7, [10, 99]] }, 'faces:7,10-99'],
  ];
  for (const [from, text] of said) {
    seen.length = 0;
    await client.isolines(plane, { from, levels: [1], method: 'exact' });
    assert.equal(
      decodeURIComponent(seen[0]!),
      `GET ${base}/isolines?from=${text}&levels=1&method=exact`,
    );
  }
  seen.length = 0;
  const from: SourceLines = { curve: { points: [{ xyz: [10, 10, 0], max_snap: 1 }, 1090] } };
  const path = await client.path(plane, { from, to: 'p:40.25,3,0', method: 'exact' });
  assert.equal(seen[0], `POST ${base}/path`);
  assert.ok(Math.abs(path.length! - 7) < 1e-9);
  assert.equal(path.from.kind, 'curve');
});

test('rows and columns of tables are lines, too', async () => {
  const query: TableQuery = {
    from: [{ boundary: 'all' }, { curve: { points: [1010, 1090] } }, { faces: [[0, 1]] }, 0],
    to: [303, 5050],
    method: 'exact',
  };
  const { rows, distances } = await client.table(plane, query);
  assert.deepEqual(rows.map(({ kind }) => kind), ['boundary', 'curve', 'faces', undefined]);
  assert.ok(Math.abs(distances[0]! - 3) < 1e-9);
  assert.ok(Math.abs(distances[3]! - 40) < 1e-9);
  for await (const { row, distances: streamed } of client.tableRows(plane, query)) {
    assert.deepEqual(streamed, distances.slice(2 * row, 2 * row + 2));
  }
  const near = await client.sparseTable(plane, { ...query, max: 5 });
  assert.deepEqual([...near.indptr], [0, 1, 1, 2, 3]);
  const turned = await client.table(plane, { ...query, from: query.to!, to: query.from });
  assert.deepEqual(turned.columns, rows);
  const square = await client.table(plane, { from: query.from, method: 'exact' });
  for (const row of [0, 1, 2, 3]) {
    for (const column of [0, 1]) assert.equal(turned.distances[4 * column + row], distances[2 * row + column]);
    for (const other of [0, 1, 2, 3]) {
      assert.equal(square.distances[4 * row + other], square.distances[4 * other + row]);
    }
  }
  assert.ok(Math.abs(square.distances[1]! - 9) < 1e-9);
  for await (const { row, distances: streamed } of client.tableRows(plane, { from: query.from, method: 'exact' })) {
    assert.deepEqual(streamed, square.distances.slice(4 * row, 4 * row + 4));
  }
});

test('more curves than one request may have are asked for in blocks', async () => {
  const curve = (place: number): SourceLines => ({ curve: { points: [place, place + 1] } });
  const places = Array.from({ length: 600 }, (_, place) => 16 * place);
  const ask = { to: [4444, 5], method: 'dijkstra' } as const;
  seen.length = 0;
  const whole = await client.table(plane, { ...ask, from: places.map(curve) });
  assert.equal(seen.filter((line) => line.includes('/table')).length, 2);
  const part = await client.table(plane, { ...ask, from: places.slice(480, 520).map(curve) });
  assert.deepEqual(whole.distances.slice(960, 1040), part.distances);
  assert.equal(whole.rows.length, 600);
  seen.length = 0;
  const texts = places.map((place) => `curve:v:${place};v:${place + 1}`);
  const turned = await client.table(plane, { from: [4444, 5], to: texts, method: 'dijkstra' });
  assert.equal(seen.filter((line) => line.includes('/table')).length, 2);
  assert.equal(turned.columns.length, 600);
});

test('sites of cells are lines, too', async () => {
  // Across the plane at y = 10 and y = 40.
  const from: SourceLines[] = [
    { curve: { points: [1000, 1099] } },
    { curve: { points: [4000, 4099] } },
  ];
  const { cells, bisectors } = await client.voronoi(plane, { from, method: 'exact' });
  assert.deepEqual(cells.map(({ site }) => site.kind), ['curve', 'curve']);
  assert.ok(Math.abs(cells[0]!.area - 99 * 25) < 1e-6);
  assert.equal(bisectors.length, 1);
  await assert.rejects(
    client.voronoi(plane, { from, relax: 1 }),
    (error: GeodesicError) => error.parameter === 'relax',
  );
});

test('distances are below 0 inside a closed curve', async () => {
  // From (20, 30) to (60, 50).
  const from: SourceLines = { curve: { points: [3020, 3060, 5060, 5020], closed: true } };
  const { values } = await client.distance(plane, { from, signed: true, method: 'exact' });
  assert.equal(values[4040], -10);
  assert.equal(values[4070], 10);
  const at = await client.distancesAt(plane, {
    from, signed: true, method: 'exact', at: ['p:40.5,40.5,0'],
  });
  assert.equal(at.signed, true);
  assert.ok(Math.abs(at.distances[0]! + 9.5) < 1e-9);
});

test('the metadata lists the loops of the boundary', async () => {
  const { boundaries } = await client.mesh(plane);
  assert.deepEqual(boundaries, [{ length: 396, edges: 396, closed: true, vertex: 0 }]);
});
