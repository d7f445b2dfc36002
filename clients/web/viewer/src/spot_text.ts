/**
 * Places and lines on the surface as texts: as links have them (`5,0.3,0.3`, or `v:12` before the mesh is
 * here; several with `;` between them), and as the API has them (`f:5,0.3,0.3`).
 */
import { MOST_LOOP, type Line, type Spot } from './state.ts';

/** Rounds weights so that the link is short and says the same point as the page. */
export function spotOf(face: number, first: number, second: number): Spot {
  const a = Math.round(Math.min(1, Math.max(0, first)) * 1e6);
  const b = Math.min(1e6 - a, Math.round(Math.min(1, Math.max(0, second)) * 1e6));
  return { face, bary: [a / 1e6, b / 1e6, (1e6 - a - b) / 1e6] };
}

/** A point of an answer that lies on a face, as it was answered. */
export function resolvedSpot({ face, bary }: { face: number | null; bary: readonly number[] | null }): Spot {
  return { face: face!, bary: bary as unknown as Spot['bary'] };
}

export function spotText({ face, bary, vertex }: Spot): string {
  return vertex === undefined ? `${face},${bary[0]},${bary[1]}` : `v:${vertex}`;
}

export function spotIn(text: string | null | undefined): Spot | null {
  const vertex = /^v:(\d+)$/.exec(text ?? '')?.[1];
  if (vertex !== undefined) return { face: -1, bary: [1, 0, 0], vertex: Number(vertex) };
  const parts = numbersIn(text?.replace(/^f:/, ''), 3);
  if (!parts || !Number.isInteger(parts[0]) || parts[0]! < 0) return null;
  const [face, first, second] = parts as [number, number, number];
  if (first < 0 || second < 0 || first + second > 1 + 1e-9) return null;
  return spotOf(face, first, second);
}

/** So many numbers with commas between them. */
export function numbersIn(text: string | null | undefined, count: number): number[] | null {
  const parts = text?.split(',').map(Number) ?? [];
  return parts.length === count && parts.every(Number.isFinite) ? parts : null;
}

/** Such as `closed;5,0.3,0.3;9,0.2,0.5`. */
export function lineText({ points, closed }: Line): string {
  return [...(closed ? ['closed'] : []), ...points.map(spotText)].join(';');
}

export function lineIn(text: string): Line | null {
  const closed = text.startsWith('closed;');
  const parts = (closed ? text.slice(7) : text).split(';');
  const points = parts.map(spotIn).filter((spot) => spot !== null);
  const right = points.length === parts.length && points.length >= (closed ? 3 : 2) && points.length <= MOST_LOOP;
  return right ? { points, closed } : null;
}

/** A line as a wall of the API; a closed one comes back to its first point. */
export function wallText({ points, closed }: Line): string {
  return (closed ? [...points, points[0]!] : points).map(apiText).join(';');
}

/** A line as a source of the API. */
export function curveText({ points, closed }: Line): string {
  return `curve:${closed ? 'closed;' : ''}${points.map(apiText).join(';')}`;
}

function apiText({ face, bary }: Spot): string {
  return `f:${face},${bary[0]},${bary[1]}`;
}
