/**
 * Bare arrays: the little-endian numbers of a reply as the typed array that their type
 * calls for, without a copy.
 */

export type TypedArray =
  | Float32Array
  | Float64Array
  | Uint8Array
  | Uint16Array
  | Uint32Array
  | Int32Array;

/** An array with its type in NumPy's notation and its dimensions. */
export interface Shaped {
  /** Such as `<f4`. */
  dtype: string;
  shape: number[];
  /** In C order. */
  data: TypedArray;
}

const KINDS = {
  '<f4': Float32Array,
  '<f8': Float64Array,
  '|u1': Uint8Array,
  '<u2': Uint16Array,
  '<u4': Uint32Array,
  '<i4': Int32Array,
} as const;

/**
 * The `count` numbers of type `dtype` that begin at byte `offset`: a view where the offset
 * allows it. Throws RangeError for a type that is not known, or numbers past the end.
 */
export function viewAs(
  buffer: ArrayBuffer,
  dtype: string,
  offset: number,
  count: number,
): TypedArray {
  const Kind = Object.hasOwn(KINDS, dtype) ? KINDS[dtype as keyof typeof KINDS] : undefined;
  if (!Kind) throw new RangeError(`numbers of type ${dtype} are not known`);
  if (offset % Kind.BYTES_PER_ELEMENT === 0) return new Kind(buffer, offset, count);
  return new Kind(buffer.slice(offset, offset + count * Kind.BYTES_PER_ELEMENT), 0, count);
}

/** How many numbers an array of these dimensions has. */
export function countOf(shape: readonly number[]): number {
  return shape.reduce((product, side) => product * side, 1);
}

/**
 * Distances out of `u16`: whole numbers from 0 to 65534 for 0 to `max`, in mesh units;
 * 65535 is unreached and becomes +Infinity.
 */
export function dequantise(values: Uint16Array, max: number | null): Float32Array {
  const unit = (max ?? 0) / 65534;
  return Float32Array.from(values, (value) => (value === 65535 ? Infinity : value * unit));
}
