/** Reads a mesh's geometry piece by piece, so that a page can draw it before its last byte is there. */
import { reading, type Call, type Reply, type Transport } from './transport.js';
import { arraysIn, type FrameArray } from './frame.js';

/** A geometry on its way: all positions, and the first `faces` of the triangles. */
export interface ArrivingGeometry {
  /** x, y, z of each vertex, all of them. */
  positions: Float64Array;
  /** Three vertices a face; zeros from face `faces` on, which have yet to come. */
  triangles: Uint32Array;
  faces: number;
}

/**
 * Sends a call whose reply is the frame of a geometry. `arrived` is called whenever more
 * triangles are there, with the same arrays each time, and never for a reply without a
 * length. Throws as `Transport.exchange` does, and what `arrived` throws.
 */
export async function exchangeGeometry(
  transport: Transport,
  call: Call,
  arrived: (part: ArrivingGeometry) => void,
): Promise<Reply> {
  return transport.exchange(call, async (url, sent, headers) => {
    const guarded = <T>(act: () => Promise<T>) => reading(sent, url, act);
    const response = await transport.send(url, sent, headers);
    const whole = Number(response.headers.get('Content-Length') ?? 0);
    const body =
      response.ok && response.body && whole > 0
        ? await received(response.body, whole, (part) => {
            sent.signal?.throwIfAborted();
            arrived(part);
          }, guarded)
        : await guarded(() => response.arrayBuffer());
    return { status: response.status, headers: response.headers, body };
  });
}

/** The body in one buffer, looked at after each piece; `whole`: how many bytes it should have. */
async function received(
  stream: ReadableStream<Uint8Array>,
  whole: number,
  arrived: (part: ArrivingGeometry) => void,
  guarded: <T>(act: () => Promise<T>) => Promise<T>,
): Promise<ArrayBuffer> {
  const body = new ArrayBuffer(whole);
  const bytes = new Uint8Array(body);
  const reader = stream.getReader();
  const more: Uint8Array<ArrayBuffer>[] = []; // what somebody on the way has packed has another length
  let count = 0;
  let part: ArrivingGeometry | null | undefined; // null: it cannot be told
  try {
    for (;;) {
      const { done, value } = await guarded(() => reader.read());
      if (done) break;
      const fits = value.subarray(0, whole - count);
      bytes.set(fits, count);
      if (fits.length < value.length) more.push(value.slice(fits.length));
      count += fits.length;
      if (part === undefined) {
        const arrays = arraysIn(body, count);
        if (arrays) part = partOf(body, arrays);
      }
      if (!part) continue;
      const faces = Math.min(part.triangles.length / 3, Math.floor((count - part.triangles.byteOffset) / 12));
      if (faces <= part.faces) continue;
      part.faces = faces;
      arrived(part);
    }
  } catch (error) {
    void reader.cancel().catch(() => {}); // the rest need not come
    throw error;
  }
  if (more.length) return new Blob([body, ...more]).arrayBuffer();
  return count === whole ? body : body.slice(0, count);
}

/** Null where the triangles do not come last, or the buffer is too small for them. */
function partOf(body: ArrayBuffer, arrays: readonly FrameArray[]): ArrivingGeometry | null {
  const [positions, triangles] = ['positions', 'triangles'].map((wanted) => arrays.find(({ name }) => name === wanted));
  if (!positions || !triangles || positions.offset > triangles.offset) return null;
  if (triangles.offset + triangles.nbytes > body.byteLength) return null;
  return {
    positions: new Float64Array(body, positions.offset, positions.nbytes / 8),
    triangles: new Uint32Array(body, triangles.offset, triangles.nbytes / 4),
    faces: 0,
  };
}
