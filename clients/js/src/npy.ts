/** The decoder of NumPy's `.npy`, as the server writes it: C order, little-endian. */
import { countOf, viewAs, type Shaped } from './arrays.js';

/**
 * Decodes a `.npy` file of version 1 to 3. Throws RangeError if the buffer is none, is in
 * Fortran's order or is cut short.
 */
export function decodeNpy(buffer: ArrayBuffer): Shaped {
  const head = new DataView(buffer);
  const isNpy =
    buffer.byteLength >= 12 && head.getUint32(0) === 0x934e554d && head.getUint16(4) === 0x5059;
  if (!isNpy) throw new RangeError('no .npy file');
  const wide = head.getUint8(6) > 1;
  const start = wide ? 12 : 10;
  const length = wide ? head.getUint32(8, true) : head.getUint16(8, true);
  if (start + length > buffer.byteLength) throw new RangeError("the .npy file's header is cut short");
  const text = new TextDecoder().decode(new Uint8Array(buffer, start, length));
  const dtype = /'descr':\s*'([^']+)'/.exec(text)?.[1];
  const sides = /'shape':\s*\(([^)]*)\)/.exec(text)?.[1];
  if (dtype === undefined || sides === undefined || !/'fortran_order':\s*False/.test(text)) {
    throw new RangeError(`an array of this kind is not known: ${text.trim()}`);
  }
  const shape = sides.split(',').map((side) => side.trim()).filter(Boolean).map(Number);
  return { dtype, shape, data: viewAs(buffer, dtype, start + length, countOf(shape)) };
}
