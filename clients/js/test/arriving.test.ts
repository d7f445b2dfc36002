/** A geometry that is looked at before it is there whole. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GeodesicClient, GeodesicError } from 'geodesicd-client';
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
