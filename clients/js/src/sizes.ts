/** What the points of a request take of the server's limits, and runs of them that fit. */
import { pointInJson, type Point, type SourceLines } from './points.js';

export type Row = Point | SourceLines;

/** What points, lines and faces take of what a request may have. */
export interface Size {
  readonly number: number;
  /** In the request's body. */
  readonly bytes: number;
  /** How many are no points. */
  readonly lines: number;
  /** Points of the curves among them. */
  readonly curvePoints: number;
}

/** Consecutive points, `end` excluded. */
export interface Run {
  readonly begin: number;
  readonly end: number;
}

const NOTHING: Size = { number: 0, bytes: 0, lines: 0, curvePoints: 0 };

const encoder = new TextEncoder();

/** The size of each. */
export function sizesOf(points: readonly Row[]): Size[] {
  return points.map((point) => ({
    number: 1,
    bytes: encoder.encode(JSON.stringify(pointInJson(point))).length + 1,
    lines: isPoint(point) ? 0 : 1,
    curvePoints: curvePointsOf(point),
  }));
}

/** The size of all. */
export function totalOf(points: readonly Row[]): Size {
  return sizesOf(points).reduce(plus, NOTHING);
}

/** Whether a size is no more of anything. */
export function fits(size: Size, most: Size): boolean {
  return (
    size.number <= most.number &&
    size.bytes <= most.bytes &&
    size.lines <= most.lines &&
    size.curvePoints <= most.curvePoints
  );
}

/** Consecutive runs of at most that size together, though at least of one point. */
export function* cuts(sizes: readonly Size[], most: Size): Generator<Run> {
  let begin = 0;
  let taken = NOTHING;
  for (const [index, size] of sizes.entries()) {
    let both = plus(taken, size);
    if (index > begin && !fits(both, most)) {
      yield { begin, end: index };
      begin = index;
      both = size;
    }
    taken = both;
  }
  yield { begin, end: sizes.length };
}

function plus(one: Size, other: Size): Size {
  return {
    number: one.number + other.number,
    bytes: one.bytes + other.bytes,
    lines: one.lines + other.lines,
    curvePoints: one.curvePoints + other.curvePoints,
  };
}

function isPoint(row: Row): boolean {
  if (typeof row === 'string') return /^(v|f|p|ray):/.test(row);
  if (typeof row !== 'object' || row === null) return true;
  return 'vertex' in row || 'face' in row || 'xyz' in row || 'ray' in row;
}

/** What is not well formed counts as none, for the server to refuse it. */
function curvePointsOf(row: Row): number {
  if (typeof row === 'string') {
    const curve = /^curve:(?:closed;)?(.*)$/s.exec(row);
    return curve ? curve[1]!.split(';').length : 0;
  }
  if (typeof row !== 'object' || row === null || !('curve' in row)) return 0;
  const points: unknown = row.curve?.points;
  return Array.isArray(points) ? points.length : 0;
}
