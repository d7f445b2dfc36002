/**
 * Points as clients say them, and their two forms on the wire: the grammar of URLs, which
 * makes queries that browsers can cache, and JSON, which can say all.
 */
import type { Xyz } from './contract.js';
import { isWholeFaces, wholeFacesInUrl, type WholeFaces } from './whole_faces.js';

/** A point; a bare number is a source vertex, a text is the grammar of URLs (`v:12`). */
export type Point =
  | number
  | string
  | { readonly vertex: number }
  | { readonly face: number; readonly bary: Xyz }
  | { readonly xyz: Xyz; readonly max_snap?: number }
  | { readonly ray: { readonly origin: Xyz; readonly direction: Xyz } };

/** A point that may carry the distance that its front starts with, in mesh units. */
export type Source =
  | number
  | string
  | (Exclude<Point, number | string> & { readonly offset?: number });

/**
 * A source that is no point: the boundary or a loop of it (the longest is 0), a curve along points,
 * or whole faces as regions have them.
 */
export type SourceLines =
  | { readonly boundary: number | 'all' }
  | { readonly curve: { readonly points: readonly Point[]; readonly closed?: boolean } }
  | WholeFaces;

export type OneOrMore<T> = T | readonly T[];

export function listOf<T>(some: OneOrMore<T>): readonly T[] {
  return Array.isArray(some) ? (some as readonly T[]) : [some as T];
}

/** The point in a URL; undefined where the grammar of URLs cannot say the same. */
export function pointInUrl(point: Source | SourceLines): string | undefined {
  if (typeof point === 'string') return point;
  if (typeof point === 'number') return `v:${point}`;
  if ('boundary' in point || 'curve' in point) return linesInUrl(point);
  if (isWholeFaces(point)) return wholeFacesInUrl(point);
  if (point.offset !== undefined) return undefined;
  if ('vertex' in point) return `v:${point.vertex}`;
  if ('face' in point) return faceInUrl(point.face, point.bary);
  if ('xyz' in point) {
    return point.max_snap === undefined ? `p:${point.xyz.join(',')}` : undefined;
  }
  return `ray:${[...point.ray.origin, ...point.ray.direction].join(',')}`;
}

/** The points of a line, each in a URL; undefined where they are no points, or one cannot be said so. */
export function pointsInUrl(points: unknown): string[] | undefined {
  if (!Array.isArray(points)) return undefined;
  const texts = points.map((point) =>
    point !== null && ['object', 'number', 'string'].includes(typeof point)
      ? pointInUrl(point as Source)
      : undefined,
  );
  return texts.includes(undefined) ? undefined : (texts as string[]);
}

/** The point in JSON. */
export function pointInJson(point: Source | SourceLines): unknown {
  if (typeof point === 'number') return { vertex: point };
  if (typeof point === 'object' && point !== null && 'curve' in point && Array.isArray(point.curve?.points)) {
    return { ...point, curve: { ...point.curve, points: point.curve.points.map(pointInJson) } };
  }
  return point;
}

/** A boundary or a curve. What is not well formed goes as JSON, for the server to refuse it. */
function linesInUrl(lines: Extract<SourceLines, { boundary: unknown } | { curve: unknown }>): string | undefined {
  if (Object.keys(lines).length !== 1) return undefined;
  if ('boundary' in lines) {
    return lines.boundary === 'all' ? 'boundary' : `boundary:${lines.boundary}`;
  }
  const { points, closed, ...rest } = lines.curve;
  if (Object.keys(rest).length > 0) return undefined;
  if (closed !== undefined && typeof closed !== 'boolean') return undefined;
  const texts = pointsInUrl(points);
  if (!texts) return undefined;
  return `curve:${[...(closed === true ? ['closed'] : []), ...texts].join(';')}`;
}

/**
 * A URL has two weights and the third is the rest, so weights that do not add up to 1 go
 * as JSON, for the server to refuse them rather than for us to mend them.
 */
function faceInUrl(face: number, bary: Xyz): string | undefined {
  const [first, second, third] = bary;
  if (bary.length !== 3 || first === undefined || second === undefined || third === undefined) {
    return undefined;
  }
  if (!(Math.abs(first + second + third - 1) < 1e-12)) return undefined;
  return `f:${face},${first},${second}`;
}
