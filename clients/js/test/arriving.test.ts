/** A geometry that is looked at before it is there whole. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient, GeodesicError, NetworkError } from 'geodesicd-client';
import { fixture } from './fixture.js';

const { client, plane, server } = await fixture();

/** A client whose replies come in pieces, and with other headers. */
function inPieces(size: number, change: (headers: Headers) => void = () => {}): GeodesicClient {
  return new GeodesicClient(server.url, {
    retries: 0,
    fetch: async (...asked) => {
      const reply = await fetch(...asked);
      const bytes = new Uint8Array(await reply.arrayBuffer());
      let at = 0;
      const body = new ReadableStream<Uint8Array>({
        pull(control) {
          if (at >= bytes.length) return control.close();
          control.enqueue(bytes.slice(at, (at += size)));
        },
      });
      const headers = new Headers(reply.headers);
      change(headers);
      return new Response(body, { status: reply.status, headers });
    },
  });
}

test('positions are whole, triangles come one after the other, and the end is the geometry', async () => {
  const whole = await client.geometry(plane, { values: 'f64' });
  for (const size of [997, 12_345, 1 << 24]) {
    const counts: number[] = [];
    const got = await inPieces(size).geometry(plane, {
      values: 'f64',
      onArrival: ({ positions, triangles, faces }) => {
        assert.deepEqual(positions, whole.positions);
        assert.equal(triangles.length, whole.triangles.length);
        assert.deepEqual(triangles.subarray(0, 3 * faces), whole.triangles.subarray(0, 3 * faces));
        counts.push(faces);
      },
    });
    assert.deepEqual(got, whole);
    assert.ok(counts.every((count, index) => index === 0 || count > counts[index - 1]!));
    assert.equal(counts.at(-1), whole.triangles.length / 3);
    if (size === 997) assert.ok(counts.length > 100);
  }
});

test('a length that is missing or of a packed body takes nothing away', async () => {
  const whole = await client.geometry(plane, { values: 'f64' });
  for (const length of [null, '1000', '400000']) {
    const other = inPieces(5000, (headers) => {
      if (length) headers.set('Content-Length', length);
      else headers.delete('Content-Length');
    });
    const onArrival = () => assert.fail('it is not known where the triangles are');
    assert.deepEqual(await other.geometry(plane, { values: 'f64', onArrival }), whole);
  }
});

test('errors are those of any call', async () => {
  const onArrival = () => assert.fail('there is nothing');
  await assert.rejects(inPieces(10).geometry('0'.repeat(64), { onArrival }), (error) => error instanceof GeodesicError && error.code === 'mesh_unknown');
  await assert.rejects(client.geometry(plane, { onArrival: () => { throw new Error('of the page'); } }), /of the page/);
  const aborted = new AbortController();
  const asked = inPieces(100).geometry(plane, { signal: aborted.signal, onArrival: () => aborted.abort() });
  await assert.rejects(asked, { name: 'AbortError' });
});

/** A geometry's frame with one part of it changed, in bytes or in the JSON about its arrays. */
type Damage = (bytes: Uint8Array, arrays: { name: string; offset: number; nbytes: number }[]) => void;
const DAMAGES: Record<string, Damage> = {
  'that is none': (bytes) => bytes.set([0], 0),
  'of another version': (bytes) => bytes.set([2], 4),
  'whose JSON is cut short': (bytes) => bytes.set([9, 0, 0, 0], 8),
  'whose JSON cannot be read': (bytes) => bytes.set(new TextEncoder().encode('['), 24),
  'whose positions do not lie evenly': (_, arrays) => (arrays.find(({ name }) => name === 'positions')!.offset += 1),
  'whose positions are less than none': (_, arrays) => (arrays.find(({ name }) => name === 'positions')!.nbytes = -8),
  'whose triangles do not lie evenly': (_, arrays) => {
    const triangles = arrays.find(({ name }) => name === 'triangles')!;
    triangles.offset -= 2;
  },
};

for (const [what, damage] of Object.entries(DAMAGES)) {
  test(`a frame ${what} is given up, and the rest of it with it`, async () => {
    const reply = await client.request({ method: 'GET', path: `/v1/meshes/${plane}/geometry?format=frame` });
    const bytes = new Uint8Array(reply.body);
    const length = new DataView(reply.body).getUint32(8, true);
    const text = new TextDecoder().decode(bytes.subarray(24, 24 + length));
    const json = JSON.parse(text) as { arrays: { name: string; offset: number; nbytes: number }[] };
    damage(bytes, json.arrays);
    if (JSON.stringify(json) !== JSON.stringify(JSON.parse(text))) {
      bytes.set(new TextEncoder().encode(JSON.stringify(json).padEnd(length)), 24);
    }
    let cancelled = false;
    const body = new ReadableStream<Uint8Array>({
      start: (control) => control.enqueue(bytes.slice(0, 24 + length)), // and then nothing for ever
      cancel: () => void (cancelled = true),
    });
    const headers = { 'Content-Length': String(bytes.length) };
    const by = new GeodesicClient(server.url, { retries: 0, fetch: async () => new Response(body, { headers }) });
    await assert.rejects(by.geometry(plane, { onArrival: () => {} }), RangeError);
    assert.ok(cancelled);
  });
}

test('a stream that breaks is a lost connection', async () => {
  const body = new ReadableStream<Uint8Array>({ pull: (control) => control.error(new Error('cut')) });
  const headers = { 'Content-Length': '1000' };
  const by = new GeodesicClient(server.url, { retries: 0, fetch: async () => new Response(body, { headers }) });
  await assert.rejects(by.geometry(plane, { onArrival: () => {} }), NetworkError);
});
