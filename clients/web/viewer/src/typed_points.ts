/**
 * Points as text: vertex numbers and places in space, typed in a line or in a file, and
 * where on the surface they are. Only the server knows that of a place.
 */
import type { GeodesicClient } from 'geodesicd-client';
import { spotOf } from './link.ts';
import type { Spot, Xyz } from './state.ts';
import type { Surface } from './surface.ts';

/** A vertex by its number, or a place in mesh units. */
export type Typed = number | Xyz;

/** A typed line: `12`, `12, 40 7`, `p:1.5,2,3`, or several of these. Null where it is neither. */
export function pointsInLine(line: string): Typed[] | null {
  const points: Typed[] = [];
  for (const word of line.trim().split(/[\s;]+/).filter(Boolean)) {
    const place = word.startsWith('p:');
    const numbers = (place ? word.slice(2) : word).split(',').filter(Boolean).map(Number);
    if (!numbers.length || !numbers.every(Number.isFinite) || (place && numbers.length !== 3)) return null;
    if (place) points.push(numbers as unknown as Xyz);
    else points.push(...numbers);
  }
  return points.length ? points : null;
}

/**
 * The lines of a file, `most` of them: a vertex number or x y z each; what follows # or ; is
 * a remark, and lines of words are headings. `strange` is the first that has other counts.
 */
export function pointsInFile(text: string, most: number): { points: Typed[]; strange: string | null } {
  const rows: number[][] = [];
  for (const line of text.split('\n')) {
    if (rows.length === most) break; // the rest may be a million lines
    const row = line.replace(/[#;].*/, '').split(/[\s,]+/).filter(Boolean).map(Number);
    if (row.length && row.every(Number.isFinite)) rows.push(row);
  }
  const strange = rows.find((row) => row.length !== 1 && row.length !== 3);
  return { points: rows.map((row) => (row.length === 1 ? row[0]! : (row as unknown as Xyz))), strange: strange?.join(' ') ?? null };
}

/** A point as one types it. */
export function pointText(point: Typed): string {
  return typeof point === 'number' ? String(point) : point.join(' ');
}

/** Points that are farther from the surface than this part of the mesh's size are remarked on. */
const FAR = 0.05;

/** Places in space that are far from the surface: how many, of how many, and how far the farthest is (mesh units). */
export interface FarPlaces {
  readonly count: number;
  readonly of: number;
  readonly farthest: number;
}

/**
 * Where the points are on the surface, null for a vertex that it does not have, and which
 * places are far from it. Rejects as the client does.
 */
export async function spotsOf(
  points: readonly Typed[],
  surface: Surface,
  client: GeodesicClient,
): Promise<{ spots: (Spot | null)[]; far: FarPlaces | null }> {
  const places = points.filter((point) => typeof point !== 'number');
  const found = places.length ? (await client.nearest(surface.id, { point: places.map((xyz) => ({ xyz })) })).points : [];
  let next = 0;
  const spots = points.map((point) => {
    if (typeof point === 'number') return surface.spotAt(point);
    const { face, bary } = found[next++]!;
    return face == null || !bary ? null : spotOf(face, bary[0]!, bary[1]!);
  });
  const { min, max } = surface.about.bbox;
  const limit = FAR * Math.hypot(...max.map((upper, axis) => upper - min[axis]!));
  const away = found.map(({ snap_distance }) => snap_distance).filter((distance) => distance > limit);
  return { spots, far: away.length ? { count: away.length, of: places.length, farthest: Math.max(...away) } : null };
}
