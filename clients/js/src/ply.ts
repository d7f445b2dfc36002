/**
 * Meshes that are arrays and no file: a binary PLY says all that they have, float64 with
 * every digit, and the server numbers its vertices and faces as the arrays do.
 */

/** Three numbers a vertex and three vertices a face. */
export interface MeshArrays {
  /** x, y, z of each vertex. A Float64Array is not rounded. */
  positions: Float32Array | Float64Array | readonly number[];
  /** Without it each three vertices are a face. */
  index?: Uint16Array | Uint32Array | readonly number[] | undefined;
}

/** What of a three.js `BufferGeometry` is used; three itself is not needed. */
export interface GeometryLike {
  getAttribute(name: string): unknown;
  getIndex(): { readonly count: number; getX(at: number): number } | null;
}

interface Attribute {
  readonly count: number;
  readonly array?: unknown;
  getX(at: number): number;
  getY(at: number): number;
  getZ(at: number): number;
}

/** The mesh as a binary little-endian PLY. Throws RangeError if counts do not fit. */
export function plyOf(mesh: MeshArrays | GeometryLike): Uint8Array {
  const { positions, index } = 'getAttribute' in mesh ? arraysOf(mesh) : mesh;
  const vertices = positions.length / 3;
  const corners = index?.length ?? vertices;
  if (!Number.isInteger(vertices)) throw new RangeError('positions are three numbers a vertex');
  if (corners % 3 !== 0) throw new RangeError('a face has three corners');
  // A plain list may have any number, and is written as it is.
  const wide = !(positions instanceof Float32Array);
  const kind = wide ? 'double' : 'float';
  const head = new TextEncoder().encode(
    `ply\nformat binary_little_endian 1.0\nelement vertex ${vertices}\n` +
      `property ${kind} x\nproperty ${kind} y\nproperty ${kind} z\n` +
      `element face ${corners / 3}\nproperty list uchar uint vertex_indices\nend_header\n`,
  );
  const width = wide ? 8 : 4;
  const bytes = new Uint8Array(head.length + positions.length * width + (corners / 3) * 13);
  bytes.set(head);
  const view = new DataView(bytes.buffer);
  let at = head.length;
  for (let i = 0; i < positions.length; i++, at += width) {
    if (wide) view.setFloat64(at, positions[i]!, true);
    else view.setFloat32(at, positions[i]!, true);
  }
  for (let corner = 0; corner < corners; corner++) {
    if (corner % 3 === 0) view.setUint8(at++, 3);
    const vertex = index ? index[corner]! : corner;
    if (!(vertex >= 0 && vertex < vertices)) throw new RangeError(`index[${corner}] is ${vertex}, of ${vertices} vertices`);
    view.setUint32(at, vertex, true);
    at += 4;
  }
  return bytes;
}

/** Whatever the attribute is made of (interleaved, normalised), as plain numbers. */
function arraysOf(geometry: GeometryLike): MeshArrays {
  const position = geometry.getAttribute('position') as Attribute | undefined;
  if (!position) throw new RangeError('the geometry has no attribute `position`');
  const wide = position.array instanceof Float64Array;
  const positions = new (wide ? Float64Array : Float32Array)(3 * position.count);
  for (let i = 0; i < position.count; i++) {
    positions[3 * i] = position.getX(i);
    positions[3 * i + 1] = position.getY(i);
    positions[3 * i + 2] = position.getZ(i);
  }
  const corners = geometry.getIndex();
  if (!corners) return { positions };
  return { positions, index: Uint32Array.from({ length: corners.count }, (_, i) => corners.getX(i)) };
}
