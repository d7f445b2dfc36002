/**
 * For pages that draw with three.js: a field onto a geometry, a path and isolines as lines, a
 * map of the surface round a point as a decal.
 * Positions are those of the server's geometry, in mesh units.
 */
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  Line,
  LineBasicMaterial,
  LineSegments,
  SRGBColorSpace,
  type Material,
} from 'three';
import { colourAt, type ColourMap } from './colour_maps.js';
import type { Isoline, MeshPart, Xyz } from './contract.js';
import type { Logmap } from './queries.js';

type Values = Float32Array | Float64Array | Uint32Array | Uint16Array;

/**
 * The slice of an array per source vertex that belongs to one part, a view. `itemSize` is
 * numbers a vertex: 1 for a field, 3 for positions.
 */
export function verticesOf<A extends Values>(values: A, part: MeshPart, itemSize = 1): A {
  const start = part.first_vertex * itemSize;
  return values.subarray(start, start + part.vertex_count * itemSize) as A;
}

/**
 * Puts one number a vertex on a geometry as the attribute `name`, for a shader. A field of
 * the same length takes the place of the one before, without a new buffer on the GPU.
 * Float64 becomes float32, labels stay exact. Throws RangeError if the geometry has another
 * number of vertices.
 */
export function setField(geometry: BufferGeometry, values: Values, name = 'field'): BufferAttribute {
  const count = geometry.getAttribute('position')?.count;
  if (count !== values.length) {
    throw new RangeError(`${values.length} values for a geometry of ${count ?? 0} vertices`);
  }
  // A copy, since the next field is written over it.
  const wanted = values instanceof Float64Array ? new Float32Array(values) : values.slice();
  const before = geometry.getAttribute(name);
  if (
    before instanceof BufferAttribute &&
    before.array.constructor === wanted.constructor &&
    before.array.length === wanted.length
  ) {
    before.array.set(wanted);
    before.needsUpdate = true;
    return before;
  }
  const attribute = new BufferAttribute(wanted, 1);
  geometry.setAttribute(name, attribute);
  return attribute;
}

/** How numbers become colours: `max` is the map's upper end, else the greatest finite number, sign aside. */
export interface Colouring {
  map?: ColourMap;
  max?: number;
  /** Of what is unreached. */
  unreached?: number | string;
}

/**
 * Colours a geometry by one number a vertex, as the attribute `color` of any material with
 * `vertexColors: true`. Numbers are distances: the map begins at 0, or has 0 in its middle where
 * some are below 0, as signed distances are. Throws RangeError if the geometry has another number
 * of vertices.
 */
export function setColours(geometry: BufferGeometry, values: Values, how: Colouring = {}): BufferAttribute {
  const count = geometry.getAttribute('position')?.count;
  if (count !== values.length) {
    throw new RangeError(`${values.length} values for a geometry of ${count ?? 0} vertices`);
  }
  let least = 0;
  let greatest = 0;
  for (const value of values) {
    if (value < least) least = value;
    else if (value < Infinity && value > greatest) greatest = value;
  }
  const max = how.max ?? Math.max(greatest, -least);
  const begin = least < 0 ? -max : 0;
  // three.js computes in linear light: each of 256 steps is turned into it once.
  const steps = Array.from({ length: 256 }, (_, step) => {
    const [r, g, b] = colourAt(how.map ?? 'viridis', step / 255);
    return new Color().setRGB(r / 255, g / 255, b / 255, SRGBColorSpace);
  });
  const nowhere = new Color(how.unreached ?? 0x9a9a9a);
  const before = geometry.getAttribute('color');
  const again = before instanceof BufferAttribute && before.array instanceof Float32Array && before.itemSize === 3;
  const attribute = again && before.count === count ? before : new BufferAttribute(new Float32Array(3 * count), 3);
  values.forEach((value: number, vertex: number) => {
    const within = Math.min(Math.max(value, begin), max);
    const step = max > 0 ? Math.round((255 * (within - begin)) / (max - begin)) : 0;
    (value < Infinity ? steps[step]! : nowhere).toArray(attribute.array, 3 * vertex);
  });
  attribute.needsUpdate = true;
  geometry.setAttribute('color', attribute);
  return attribute;
}

/** A path, a trace, their frame's `points`, or positions: whatever has a line's points. */
export type LinePoints =
  | { readonly points: readonly { readonly xyz: Xyz }[] }
  | { readonly arrays: { readonly points?: unknown } }
  | readonly Xyz[]
  | Float32Array
  | Float64Array;

/** x, y, z of each point of a line. */
export function linePositions(line: LinePoints): Float32Array {
  if (line instanceof Float32Array) return line;
  if (line instanceof Float64Array) return new Float32Array(line);
  if ('arrays' in line) return linePositions(line.arrays.points as Float64Array);
  const points = 'points' in line ? line.points.map((point) => point.xyz) : line;
  const positions = new Float32Array(points.length * 3);
  points.forEach((xyz, index) => positions.set(xyz, index * 3));
  return positions;
}

/** A path or a trace as a line; a path that does not reach is a line without points. */
export function pathToLine(
  path: LinePoints,
  material: Material = new LineBasicMaterial({ color: 0xff3030 }),
): Line<BufferGeometry, Material> {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(linePositions(path), 3));
  return new Line(geometry, material);
}

/**
 * Isolines as segments of one object, so that a thousand of them are one draw call. Each
 * point has its line's level in the attribute `level`.
 */
export function isolinesToSegments(
  isolines: { readonly isolines: readonly Isoline[] } | readonly Isoline[],
  material: Material = new LineBasicMaterial({ color: 0x202020 }),
): LineSegments<BufferGeometry, Material> {
  const lines = 'isolines' in isolines ? isolines.isolines : isolines;
  const positions: number[] = [];
  const levels: number[] = [];
  for (const { level, closed, points } of lines) {
    const segments = closed ? points.length : points.length - 1;
    for (let index = 0; index < segments; ++index) {
      for (const point of [points[index], points[(index + 1) % points.length]]) {
        positions.push(...(point as number[]));
        levels.push(level);
      }
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(positions), 3));
  geometry.setAttribute('level', new BufferAttribute(new Float32Array(levels), 1));
  return new LineSegments(geometry, material);
}

/** What of the map a texture covers, and what of the mesh the geometry is. */
export interface Decal {
  /** The side of the texture's square, mesh units; without it twice the map's radius. */
  size?: number;
  /** The one part of the mesh that the geometry is of; without it the geometry is of all. */
  part?: MeshPart;
}

/**
 * The faces of which all corners have a place in the map, as a geometry for a textured material.
 * In its `uv` the point is at 0.5, 0.5, u grows along the map's x axis and v along its y axis; a
 * vertex without a place has -1, -1, and no face. The other attributes are the geometry's own, which
 * stays as it is. Throws RangeError if the geometry has not all vertices of the map or the part.
 */
export function logmapToDecal(
  geometry: BufferGeometry,
  map: Pick<Logmap, 'radius' | 'vertices' | 'coordinates'>,
  { size = 2 * map.radius, part }: Decal = {},
): BufferGeometry {
  const uv = decalCoordinates(geometry, map, size || 1, part);
  const decal = new BufferGeometry();
  for (const [name, attribute] of Object.entries(geometry.attributes)) decal.setAttribute(name, attribute);
  decal.setAttribute('uv', uv.attribute);
  decal.setIndex(facesWithin(geometry, uv.placed));
  return decal;
}

/** The decal's `uv`, and by vertex whether it has a place. */
function decalCoordinates(
  geometry: BufferGeometry,
  { vertices, coordinates }: Pick<Logmap, 'vertices' | 'coordinates'>,
  size: number,
  part: MeshPart | undefined,
): { attribute: BufferAttribute; placed: boolean[] } {
  const count = geometry.getAttribute('position')?.count ?? 0;
  if (part && part.vertex_count !== count) {
    throw new RangeError(`a part of ${part.vertex_count} vertices for a geometry of ${count}`);
  }
  const attribute = new BufferAttribute(new Float32Array(2 * count).fill(-1), 2);
  const placed = new Array<boolean>(count).fill(false);
  vertices.forEach((source, index) => {
    const vertex = source - (part?.first_vertex ?? 0);
    if (vertex < 0 || vertex >= count) {
      if (part) return;
      throw new RangeError(`vertex ${source} of a map for a geometry of ${count} vertices`);
    }
    attribute.setXY(vertex, 0.5 + coordinates[2 * index]! / size, 0.5 + coordinates[2 * index + 1]! / size);
    placed[vertex] = true;
  });
  return { attribute, placed };
}

/** The corners of the faces that have only such vertices; a geometry without an index has three a face. */
function facesWithin(geometry: BufferGeometry, wanted: readonly boolean[]): number[] {
  const { index } = geometry;
  const count = index?.count ?? wanted.length;
  const corners: number[] = [];
  for (let first = 0; first + 2 < count; first += 3) {
    const face = [first, first + 1, first + 2].map((corner) => index?.getX(corner) ?? corner);
    if (face.every((vertex) => wanted[vertex])) corners.push(...face);
  }
  return corners;
}
