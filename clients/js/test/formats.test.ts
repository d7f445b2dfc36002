/** Binary as it comes and as it must not: frames, .npy, bare arrays, timings, lines. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { decodeFrame, decodeNpy, dequantise, parseTiming } from 'geodesicd-client';
import { viewAs } from '../dist/arrays.js';
import { eventsOf } from '../dist/event_stream.js';
import { linesOf } from '../dist/lines.js';
import { fixture } from './fixture.js';

const { client, plane } = await fixture();

async function wholeFrame(): Promise<ArrayBuffer> {
  const path = `/v1/meshes/${plane}/distance?from=v:0&labels=1&format=frame`;
  return (await client.request({ method: 'GET', path })).body;
}

test("a frame's arrays are views into it", async () => {
  const buffer = await wholeFrame();
  const { header, arrays } = decodeFrame(buffer);
  assert.deepEqual(Object.keys(arrays), ['distances', 'labels']);
  assert.equal(arrays['distances']!.buffer, buffer);
  assert.equal(header['mesh'], plane);
});

test('a frame with any one part damaged is refused', async () => {
  const buffer = await wholeFrame();
  const damaged = (change: (view: DataView) => void) => {
    const copy = buffer.slice(0);
    change(new DataView(copy));
    return copy;
  };
  const text = new TextDecoder().decode(new Uint8Array(buffer, 24, 400));
  const wrong: [string, ArrayBuffer][] = [
    ['nothing', new ArrayBuffer(0)],
    ['the header only', buffer.slice(0, 24)],
    ['cut short', buffer.slice(0, buffer.byteLength - 8)],
    ['too long', damaged((view) => view.setBigUint64(16, 1n, true))],
    ['no GEOD', damaged((view) => view.setUint8(0, 0))],
    ['version 2', damaged((view) => view.setUint32(4, 2, true))],
    ['JSON past the end', damaged((view) => view.setUint32(8, 0xffffffff, true))],
    ['JSON cut short', damaged((view) => view.setUint32(8, 9, true))],
    ['no known type', damaged((view) => view.setUint8(24 + text.indexOf('<f8') + 1, 0x78))],
    ['another count', damaged((view) => view.setUint8(24 + text.indexOf('[10000]') + 2, 0x31))],
  ];
  for (const [what, frame] of wrong) assert.throws(() => decodeFrame(frame), RangeError, what);
});

test('a .npy file is read, and what is none is refused', async () => {
  const path = `/v1/meshes/${plane}/path?from=v:0&to=v:2&format=npy`;
  const { body } = await client.request({ method: 'GET', path });
  const { dtype, shape, data } = decodeNpy(body);
  assert.deepEqual({ dtype, shape }, { dtype: '<f8', shape: [3, 3] });
  assert.deepEqual([...data], [0, 0, 0, 1, 0, 0, 2, 0, 0]);
  for (const end of [0, 9, 40, body.byteLength - 1]) {
    assert.throws(() => decodeNpy(body.slice(0, end)), RangeError, `${end} bytes`);
  }
});

test('an array that does not lie evenly is copied', () => {
  const bytes = new Uint8Array(17);
  new DataView(bytes.buffer).setFloat64(1, 2.5, true);
  assert.deepEqual([...viewAs(bytes.buffer, '<f8', 1, 2)], [2.5, 0]);
});

test('u16 becomes distances again, to within its step', async () => {
  const query = { of: 'distance', from: 0 } as const;
  const coarse = await client.array(plane, { ...query, format: 'u16' });
  const exact = await client.array(plane, { ...query, format: 'f64' });
  const values = dequantise(coarse.data as Uint16Array, coarse.max);
  const step = coarse.max! / 65534;
  values.forEach((value, i) => assert.ok(Math.abs(value - exact.data[i]!) <= step));
  assert.deepEqual([...dequantise(new Uint16Array([65535, 0]), null)], [Infinity, 0]);
});

test('Server-Timing is read, also with descriptions and without durations', () => {
  assert.deepEqual(parseTiming('queue;dur=0.041, solve;desc="x";dur=9.31, miss'), {
    queue: 0.041,
    solve: 9.31,
  });
  assert.deepEqual(parseTiming(null), {});
});

function streamOf(...pieces: (string | Uint8Array)[]): ReadableStream<Uint8Array> {
  return new ReadableStream({
    start(controller) {
      for (const piece of pieces) {
        controller.enqueue(typeof piece === 'string' ? new TextEncoder().encode(piece) : piece);
      }
      controller.close();
    },
  });
}

test('lines are whole whatever the pieces that they come in', async () => {
  const bytes = new TextEncoder().encode('größer\r\nzwei\n\nletzte');
  for (let cut = 0; cut <= bytes.length; ++cut) {
    const lines = [];
    for await (const line of linesOf(streamOf(bytes.slice(0, cut), bytes.slice(cut)))) {
      lines.push(line);
    }
    assert.deepEqual(lines, ['größer', 'zwei', '', 'letzte'], `cut at ${cut}`);
  }
});

test('server-sent events as the standard has them', async () => {
  const text = ': a comment\nevent: progress\nid: 1\ndata: {"a":\ndata: 1}\n\ndata:x\n\nevent: none\n\n';
  const events = [];
  for await (const event of eventsOf(streamOf(text))) events.push(event);
  assert.deepEqual(events, [
    { event: 'progress', data: '{"a":\n1}', id: '1' },
    { event: 'message', data: 'x', id: '1' },
  ]);
});
