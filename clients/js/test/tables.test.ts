/** Tables of any size are those that one request would give; errors in them are named. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  GeodesicClient,
  GeodesicError,
  NetworkError,
  type Point,
  type TableQuery,
} from 'geodesicd-client';
import { fixture, watchedFetch } from './fixture.js';

const { server, client, plane } = await fixture();
const seen: string[] = [];
const watched = new GeodesicClient(server.url, { fetch: watchedFetch(seen) });

/** What was asked for since last time: the last part of each path. */
function asked(): string[] {
  return seen.splice(0).map((line) => /([^/? ]*)(\?.*)?$/.exec(line)![1]!);
}

const upTo = (count: number, first = 0) => Array.from({ length: count }, (_, index) => first + index);

/** A server that says that it takes less; what is over the limits is refused as it would be. */
function limited(limits: Partial<Record<string, number>>): GeodesicClient {
  const watching = watchedFetch(seen);
  return new GeodesicClient(server.url, {
    fetch: async (input, init) => {
      const reply = await watching(input, init);
      if (!String(input).endsWith('/v1/status')) return reply;
      const status = (await reply.json()) as { limits: object };
      return Response.json({ ...status, limits: { ...status.limits, ...limits } });
    },
  });
}

test('more than the server takes at once is asked for in blocks', async () => {
  const from = upTo(1200);
  const to = upTo(1000, 400);
  const whole = await watched.table(plane, { from, to, method: 'dijkstra' });
  assert.deepEqual(asked(), ['status', 'table', 'table']);
  assert.equal(whole.distances.length, 1_200_000);
  assert.deepEqual(whole.rows.map(({ vertex }) => vertex), from);
  assert.deepEqual(whole.columns.map(({ vertex }) => vertex), to);
  assert.equal(whole.method, 'dijkstra');
  const few = await watched.table(plane, { from: from.slice(995, 1005), to, method: 'dijkstra' });
  assert.deepEqual(asked(), ['table']);
  assert.deepEqual(whole.distances.slice(995_000, 1_005_000), few.distances);
});

test('blocks of any size are one table', async () => {
  const points = upTo(30, 17).map((vertex): Point =>
    vertex % 3 ? vertex : { xyz: [vertex % 7, vertex % 11, 40] },
  );
  const ask: TableQuery = { from: points.slice(0, 20), to: points, method: 'fast_marching' };
  const one = await client.table(plane, ask);
  // Over what every server is taken to have, so that its limits are asked for.
  const many = { ...ask, from: upTo(50).flatMap(() => ask.from as Point[]).concat(7) };
  for (const limits of [
    { max_sources: 7, max_points: 11 },
    { max_table_entries: 20 },
    { max_json_bytes: 800 },
  ]) {
    const whole = await limited({ max_sources: 300, ...limits }).table(plane, many);
    assert.ok(asked().length > 30);
    assert.deepEqual(whole.columns, one.columns);
    assert.equal(whole.rows.length, 1001);
    assert.deepEqual(whole.rows.slice(40, 60), one.rows);
    assert.deepEqual(whole.distances.slice(40 * 30, 60 * 30), one.distances);
    assert.ok(whole.timing.encode !== undefined || whole.timing.load !== undefined);
    assert.ok(whole.warnings.length > 0);
    assert.equal(new Set(whole.warnings).size, whole.warnings.length);
  }
});

test('without columns they are the rows again', async () => {
  const rows = upTo(1001);
  const whole = await watched.table(plane, { from: rows, method: 'dijkstra' });
  assert.deepEqual(asked(), ['status', 'table', 'table']);
  assert.deepEqual(whole.columns, whole.rows);
  assert.equal(whole.distances[1000], whole.distances[1000 * 1001]);
});

test('an error in a block is named as in the whole', async () => {
  const from = [...upTo(1500), 77777];
  await assert.rejects(client.table(plane, { from, to: [0, 1], method: 'dijkstra' }), (error) => {
    assert.ok(error instanceof GeodesicError);
    assert.equal(error.code, 'index_out_of_range');
    assert.equal(error.parameter, 'from[1500]');
    assert.equal(error.limit, 9999);
    assert.match(error.message, /from\[1500\]/);
    assert.ok(error.requestId);
    return true;
  });
});

test('a deadline is for the whole', async () => {
  const query: TableQuery = { from: upTo(1500), to: upTo(1500), method: 'chen_han' };
  const late = client.table(plane, query, { deadlineMs: 50 });
  await assert.rejects(late, { status: 504, code: 'deadline' });
});

test('where the limits may not be asked for, they are those of every server', async () => {
  const fetching = watchedFetch(seen);
  const refused = new GeodesicClient(server.url, {
    fetch: async (input, init) =>
      String(input).endsWith('/status') ? new Response('', { status: 403 }) : fetching(input, init),
  });
  const whole = await refused.table(plane, { from: upTo(1001), to: [0], method: 'dijkstra' });
  assert.deepEqual(asked(), ['table', 'table']);
  assert.equal(whole.distances.length, 1001);
});

/** A client whose replies to tables break off, or end, after so many bytes, one after the other. */
function cut(how: 'broken' | 'ended', ...cuts: number[]): GeodesicClient {
  return new GeodesicClient(server.url, {
    fetch: async (input, init) => {
      const reply = await fetch(input, init);
      const most = String(input).includes('/table') ? cuts.shift() : undefined;
      if (most === undefined || !reply.body) return reply;
      let left = most;
      const body = reply.body.pipeThrough(
        new TransformStream<Uint8Array, Uint8Array>({
          transform(chunk, controller) {
            controller.enqueue(chunk.subarray(0, left));
            if (chunk.length > left) {
              if (how === 'broken') controller.error(new TypeError('terminated'));
              else controller.terminate();
            }
            left -= chunk.length;
          },
        }),
      );
      return new Response(body, { status: reply.status, headers: reply.headers });
    },
  });
}

test('rows arrive in their order, as the fields have them', async () => {
  const from = upTo(12, 900);
  const to = upTo(30, 4000);
  let next = 0;
  for await (const { row, distances } of client.tableRows(plane, { from, to })) {
    assert.equal(row, next++);
    const field = await client.distance(plane, { from: from[row]! }, { values: 'f64' });
    assert.deepEqual([...distances], to.map((vertex) => field.values[vertex]));
  }
  assert.equal(next, 12);
});

test('rows go on where the connection breaks', async () => {
  const from = upTo(9, 50);
  const all = async (some: GeodesicClient) => {
    const rows: Float64Array[] = [];
    for await (const { row, distances } of some.tableRows(plane, { from })) {
      assert.equal(row, rows.length);
      rows.push(distances);
    }
    return rows;
  };
  const whole = await all(client);
  assert.equal(whole.length, 9);
  for (const how of ['broken', 'ended'] as const) {
    // In a row, between two, and before the first of all.
    assert.deepEqual(await all(cut(how, 9 * 8 * 2 + 3, 0, 9 * 8)), whole);
    await assert.rejects(all(cut(how, 0, 0, 0, 0, 0, 0)), NetworkError);
  }
});

test('rows are asked for again as often as the client says, and none of another reply is taken', async () => {
  const from = upTo(3);
  const asking = async (retries: number, stranger: (reply: Response) => Response | Promise<Response>) => {
    let asked = 0;
    const some = new GeodesicClient(server.url, {
      retries,
      fetch: async (input, init) => {
        ++asked;
        return stranger(await fetch(input, init));
      },
    });
    await assert.rejects(async () => {
      for await (const row of some.tableRows(plane, { from })) assert.fail(`row ${row.row}`);
    }, NetworkError);
    return asked;
  };
  const page = '<html>'.repeat(9); // of two rows and more
  assert.equal(await asking(0, () => new Response(page)), 1);
  assert.equal(await asking(1, () => new Response(page, { status: 203 })), 2);
  const narrow = async (reply: Response) => {
    const headers = new Headers(reply.headers);
    headers.set('Geo-Shape', '9,1');
    return new Response(await reply.arrayBuffer(), { headers });
  };
  assert.equal(await asking(0, narrow), 1);
});

test('errors of rows are those of the table', async () => {
  await assert.rejects(
    async () => {
      for await (const row of client.tableRows(plane, { from: [0, 77777] })) assert.ok(row);
    },
    (error) => error instanceof GeodesicError && error.code === 'index_out_of_range',
  );
});

test('a sparse table has what is near', async () => {
  const from = upTo(20, 300);
  const full = await client.table(plane, { from, method: 'exact' });
  const near = await client.sparseTable(plane, { from, method: 'exact', max: 4 });
  assert.equal(near.rows.length, 20);
  assert.equal(near.indptr.length, 21);
  const filled = new Float64Array(400).fill(Infinity);
  for (let row = 0; row < 20; ++row) {
    for (let k = near.indptr[row]!; k < near.indptr[row + 1]!; ++k) {
      filled[20 * row + near.indices[k]!] = near.data[k]!;
    }
  }
  for (const [index, distance] of full.distances.entries()) {
    const expected = distance <= 4 ? distance : Infinity;
    assert.ok(filled[index] === expected || Math.abs(filled[index]! - expected) < 1e-9);
  }
});
