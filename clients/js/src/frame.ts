/**
 * The decoder of frames, `application/vnd.geodesic.frame`: 24 bytes of header, JSON, and
 * arrays that are views into the buffer, not copies of it.
 */
import { countOf, viewAs, type TypedArray } from './arrays.js';

export interface FrameArray {
  name: string;
  /** In NumPy's notation, such as `<f8`. */
  dtype: string;
  shape: number[];
  /** Bytes from the frame's first. */
  offset: number;
  nbytes: number;
}

/** The frame's JSON: the rest of the reply, and what arrays there are. */
export interface FrameHeader {
  arrays: FrameArray[];
  [name: string]: unknown;
}

export interface Frame {
  header: FrameHeader;
  arrays: Record<string, TypedArray>;
}

/**
 * Decodes a frame. Throws RangeError if the buffer is not one, is of another version or
 * is cut short.
 */
export function decodeFrame(buffer: ArrayBuffer): Frame {
  if (buffer.byteLength < 24) throw new RangeError('a frame has at least 24 bytes');
  const { header, total } = headOf(buffer);
  if (total !== BigInt(buffer.byteLength)) {
    throw new RangeError(`a frame of ${total} bytes, of which ${buffer.byteLength} are there`);
  }
  const arrays: Record<string, TypedArray> = {};
  for (const { name, dtype, shape, offset, nbytes } of header.arrays) {
    const array = viewAs(buffer, dtype, offset, countOf(shape));
    if (array.byteLength !== nbytes) throw new RangeError(`${name} has not ${nbytes} bytes`);
    arrays[name] = array;
  }
  return { header, arrays };
}

/**
 * Which arrays a frame has of which only the first `count` bytes have come; null as long as
 * these do not say. Throws RangeError as `decodeFrame` does.
 */
export function arraysIn(buffer: ArrayBuffer, count: number): FrameArray[] | null {
  if (count < 24 || count < 24 + new DataView(buffer).getUint32(8, true)) return null;
  return headOf(buffer).header.arrays;
}

function headOf(buffer: ArrayBuffer): { header: FrameHeader; total: bigint } {
  const head = new DataView(buffer);
  if (head.getUint32(0, false) !== 0x47454f44) throw new RangeError('no frame: GEOD is missing');
  const version = head.getUint32(4, true);
  if (version !== 1) throw new RangeError(`a frame of version ${version}, and only 1 is known`);
  const length = head.getUint32(8, true);
  if (24 + length > buffer.byteLength) throw new RangeError("the frame's JSON is cut short");
  const text = new TextDecoder().decode(new Uint8Array(buffer, 24, length));
  return { header: parseHeader(text), total: head.getBigUint64(16, true) };
}

function parseHeader(text: string): FrameHeader {
  let header: unknown;
  try {
    header = JSON.parse(text);
  } catch (cause) {
    throw new RangeError("the frame's JSON cannot be read", { cause });
  }
  if (!Array.isArray((header as FrameHeader | null)?.arrays)) {
    throw new RangeError("the frame's JSON names no arrays");
  }
  return header as FrameHeader;
}
