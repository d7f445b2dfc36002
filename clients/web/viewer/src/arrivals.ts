/** Whether a mesh that comes late would take away what was done meanwhile. */
import { differ, POINTS, type State } from './state.ts';

/** Whether there are points or measures that were not there before. */
export function hasNewPoints(now: State, before: State): boolean {
  const { sources, via, target, arrow, loop, painted, curves, measures } = now;
  const any = sources.length + via.length + measures.length + painted.faces.length + painted.walls.length + curves.length > 0 || target !== null || arrow !== null || loop !== null;
  return any && differ(now, before, ...POINTS, 'painted', 'measures');
}
