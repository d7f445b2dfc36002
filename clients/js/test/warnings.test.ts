/** Warnings: sentences of the server's about a question that it answers all the same. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient } from 'geodesicd-client';
import { fixture } from './fixture.js';

const { server, client, plane } = await fixture();

const ONE = 'from[0] is 12 from the surface, 9 % of the diagonal of its box';
const TWO = 'to is 30 from the surface, 21 % of the diagonal of its box';

/** Real replies, with these warnings in their header, and in their body if it is JSON and `inBody`. */
function warning(sentences: readonly string[], inBody: boolean): GeodesicClient {
  const warned: typeof fetch = async (input, init) => {
    const reply = await fetch(input, init);
    const headers = new Headers(reply.headers);
    if (sentences.length && /\/(distance|path|table|isolines|nearest|trace|loop|logmap|samples|measure|voronoi)\b/.test(String(input))) {
      headers.set('Geo-Warnings', sentences.join('; '));
    }
    const isJson = headers.get('Content-Type')?.startsWith('application/json');
    if (!isJson || !inBody) return new Response(await reply.arrayBuffer(), { status: reply.status, headers });
    const body = { ...((await reply.json()) as object), warnings: sentences };
    return new Response(JSON.stringify(body), { status: reply.status, headers });
  };
  return new GeodesicClient(server.url, { fetch: warned });
}

/** Every way to ask that resolves to a value with room for warnings. */
const WAYS: Record<string, (by: GeodesicClient) => Promise<{ warnings: string[] }>> = {
  'a field, by a frame': (by) => by.distance(plane, { from: 0 }),
  'a table, by a frame': (by) => by.table(plane, { from: [0], to: [1, 2] }),
  'a frame': (by) => by.frame(plane, { of: 'path', from: 0, to: 9 }),
  'a bare array': (by) => by.array(plane, { of: 'distance', from: 0, format: 'f32' }),
  'a NumPy file': (by) => by.array(plane, { of: 'distance', from: 0, format: 'npy' }),
  'distances at points': (by) => by.distancesAt(plane, { from: 0, at: [5] }),
  'a path': (by) => by.path(plane, { from: 0, to: 9 }),
  isolines: (by) => by.isolines(plane, { from: 0, count: 3 }),
  nearest: (by) => by.nearest(plane, { point: { xyz: [1, 2, 30] } }),
  'a trace': (by) => by.trace(plane, { from: 50, direction: [1, 0, 0], length: 3 }),
  'a loop': (by) => by.loop(plane, { through: [50, 0, 3] }),
  'a map, by a frame': (by) => by.logmap(plane, { from: 50, radius: 3 }),
  samples: (by) => by.samples(plane, { count: 3 }),
  measures: (by) => by.measure(plane, { from: 0, radii: [3, 5] }),
  cells: (by) => by.voronoi(plane, { from: [0, 99] }),
  'a query by POST': (by) => by.path(plane, { from: { xyz: [0, 0, 1], max_snap: 2 }, to: 9 }),
};

for (const [what, ask] of Object.entries(WAYS)) {
  test(`${what}: no warnings are an empty list, and others are its sentences`, async () => {
    assert.deepEqual((await ask(client)).warnings, []);
    for (const sentences of [[], [ONE], [ONE, TWO]]) {
      for (const inBody of [false, true]) {
        assert.deepEqual((await ask(warning(sentences, inBody))).warnings, sentences);
      }
    }
  });
}

test('the server warns of a point far from the surface, unless that was meant', async () => {
  const far = [50, 50, 40] as [number, number, number];
  const ask: ((from: { xyz: typeof far; max_snap?: number }) => Promise<{ warnings: string[] }>)[] = [
    (from) => client.distance(plane, { from }),
    (from) => client.array(plane, { of: 'distance', from, format: 'f32' }),
    (from) => client.path(plane, { from, to: 9 }),
    (from) => client.job(plane, { query: 'path', from, to: 9 }),
  ];
  for (const way of ask) {
    const { warnings } = await way({ xyz: far });
    assert.equal(warnings.length, 1);
    assert.match(warnings[0]!, /^The point of from is 40 away from the surface, more than .*max_snap/);
    assert.deepEqual((await way({ xyz: far, max_snap: 50 })).warnings, []);
  }
});

test('a sentence of a body stays whole, whatever it has inside', async () => {
  const path = await warning(['far; very far'], true).path(plane, { from: 0, to: 9 });
  assert.deepEqual(path.warnings, ['far; very far']);
});

test('a frame with warnings in its JSON says them without the header', async () => {
  const framed: typeof fetch = async (input, init) => {
    const reply = await fetch(input, init);
    const bytes = Buffer.from(await reply.arrayBuffer());
    const length = bytes.readUInt32LE(8);
    // The JSON grows by a whole number of eights, so that the arrays stay aligned.
    const json = JSON.parse(bytes.toString('utf8', 24, 24 + length)) as { arrays: { offset: number }[] };
    const grown = 8 * Math.ceil((ONE.length + 40) / 8);
    for (const array of json.arrays) array.offset += grown;
    const head = Buffer.alloc(24 + length + grown, ' ');
    bytes.copy(head, 0, 0, 24);
    head.writeUInt32LE(length + grown, 8);
    head.writeBigUInt64LE(BigInt(bytes.length + grown), 16);
    head.write(JSON.stringify({ ...json, warnings: [ONE] }), 24);
    return new Response(Buffer.concat([head, bytes.subarray(24 + length)]), { headers: reply.headers });
  };
  const by = new GeodesicClient(server.url, { fetch: framed });
  const field = await by.distance(plane, { from: 0 });
  assert.deepEqual([field.warnings, field.values.length], [[ONE], 10000]);
});

test('a job’s result has the warnings of its query', async () => {
  const told: typeof fetch = async (input, init) => {
    const reply = await fetch(input, init);
    const headers = new Headers(reply.headers);
    if (String(input).endsWith('/result')) headers.set('Geo-Warnings', ONE);
    return new Response(reply.body, { status: reply.status, headers });
  };
  const path = await new GeodesicClient(server.url, { fetch: told }).job(plane, { query: 'path', from: 0, to: 9 });
  assert.deepEqual(path.warnings, [ONE]);
});

test('answers of a batch have theirs', async () => {
  const told: typeof fetch = async (input, init) => {
    const lines = (await (await fetch(input, init)).text()).trim().split('\n').map((line) => JSON.parse(line));
    lines[1].reply.warnings = [ONE, TWO];
    return new Response(lines.map((line) => `${JSON.stringify(line)}\n`).join(''));
  };
  const answers = [];
  const asked = [1, 2, 3].map((to) => ({ query: 'path', from: 0, to }) as const);
  for await (const answer of new GeodesicClient(server.url, { fetch: told }).batch(plane, asked)) answers.push(answer);
  assert.deepEqual(answers.map((answer) => answer.ok && answer.reply.warnings), [[], [ONE, TWO], []]);
});
