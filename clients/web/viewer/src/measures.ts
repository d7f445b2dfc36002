/** The list of kept paths: what is kept of the one that is shown, and by which letter it is called. */
import type { Path } from 'geodesicd-client';
import type { Results } from './results.ts';
import { byCost, MOST_MEASURES, type Measure, type State } from './state.ts';

/** The path that is shown, with what its length is asked by; null where it is none for the list, or that is full. */
export function keptOf(state: State, { path, pathStart, stale }: Results): { measure: Measure; path: Path } | null {
  const { curves, via, target, method, pointsPerEdge, refine, painted, measures } = state;
  if (!path?.reachable || stale || !target || !pathStart || 'points' in pathStart || curves.length || byCost(state) || measures.length >= MOST_MEASURES) return null;
  return { measure: { from: pathStart, via, to: target, method, pointsPerEdge, refine, painted }, path };
}

/** A, B, …, Z, A1, … */
export function letterOf(index: number): string {
  const letter = String.fromCharCode(65 + (index % 26));
  return index < 26 ? letter : `${letter}${Math.floor(index / 26)}`;
}
