/** Painted faces and walls: as the regions of a query, as a text for links and keys, and as a byte a face. */
import type { Region, WholeFaces } from 'geodesicd-client';
import { wallText } from './spot_text.ts';
import { isWeighted, UNPAINTED, type Painted } from './state.ts';

type Ranges = Painted['faces'];

/** Of paths over painted faces. */
export const LEAST_WEIGHT = 0.1;
export const MOST_WEIGHT = 10;

/** So long a text still goes into a link. */
export const LONGEST_TEXT = 30_000;

/** What of the surface a query is about. */
export function regionsOf({ as, faces, walls }: Painted): { within?: Region; forbid?: Region; walls?: readonly string[] } {
  const closed = walls.length ? { walls: walls.map(wallText) } : {};
  return !faces.length || as === 'weights' ? closed : { ...closed, [as]: regionOf(faces) };
}

/** What paths over them cost. */
export function weightsOf(painted: Painted): { weights?: { weight: number; region: WholeFaces } } {
  return isWeighted(painted) ? { weights: { weight: painted.weight, region: regionOf(painted.faces) } } : {};
}

function regionOf(faces: Ranges): WholeFaces {
  return { faces: faces.map(([first, last]) => (first === last ? first : ([first, last] as const))) };
}

/** A byte a face, 1 where it is painted. */
export function maskOf({ faces }: Painted, count: number): Uint8Array {
  const mask = new Uint8Array(count);
  for (const [first, last] of faces) mask.fill(1, first, last + 1);
  return mask;
}

/** The painted faces as ranges. */
export function rangesOf(mask: Uint8Array): [number, number][] {
  const ranges: [number, number][] = [];
  for (let face = mask.indexOf(1); face >= 0; ) {
    const end = mask.indexOf(0, face);
    const next = end < 0 ? mask.length : end;
    ranges.push([face, next - 1]);
    face = end < 0 ? -1 : mask.indexOf(1, end);
  }
  return ranges;
}

/** How many faces are painted. */
export function countOf({ faces }: Painted): number {
  return faces.reduce((sum, [first, last]) => sum + last - first + 1, 0);
}

const texts = new WeakMap<Painted, string>();

/** Such as `forbid:7,10-99`, or `weights:3*7,10-99`; empty where nothing is painted. */
export function paintedText(painted: Painted): string {
  const { as, weight, faces } = painted;
  if (!faces.length) return '';
  const known = texts.get(painted);
  if (known !== undefined) return known;
  const text = `${as}:${as === 'weights' ? `${weight}*` : ''}${faces.map(([first, last]) => (first === last ? first : `${first}-${last}`)).join(',')}`;
  texts.set(painted, text);
  return text;
}

/** What of it answers depend on. */
export function paintedKey(painted: Painted): string {
  return [paintedText(painted), ...painted.walls.map(wallText)].join('/');
}

/** What such a text says; null where it says nothing, or no faces. */
export function paintedIn(text: string): Painted | null {
  const [, as, times, listed] = /^(forbid|within|weights):(?:(\d+(?:\.\d+)?)\*)?([\d,-]+)$/.exec(text) ?? [];
  if (!listed || (as === 'weights') !== (times !== undefined)) return null;
  const weight = times === undefined ? UNPAINTED.weight : Number(times);
  if (!(weight >= LEAST_WEIGHT && weight <= MOST_WEIGHT)) return null;
  const ranges: [number, number][] = [];
  for (const each of listed.split(',')) {
    const [, first, last = first] = /^(\d{1,9})(?:-(\d{1,9}))?$/.exec(each) ?? [];
    if (first === undefined || Number(last) < Number(first)) return null;
    ranges.push([Number(first), Number(last)]);
  }
  return { as: as as Painted['as'], weight, faces: joined(ranges), walls: [] };
}

/** In ascending order, and those that touch as one. */
function joined(ranges: readonly [number, number][]): Ranges {
  const made: [number, number][] = [];
  for (const [first, last] of [...ranges].sort(([a], [b]) => a - b)) {
    const before = made.at(-1);
    if (before && first <= before[1] + 1) before[1] = Math.max(before[1], last);
    else made.push([first, last]);
  }
  return made;
}

/** What of it a mesh of so many faces has; the same where that is all. */
export function paintedOn(painted: Painted, count: number): Painted {
  const last = painted.faces.at(-1);
  if (!last || last[1] < count) return painted;
  const faces = painted.faces.filter(([first]) => first < count).map(([first, end]) => [first, Math.min(end, count - 1)] as const);
  return { ...painted, faces };
}
