/** Points that a mesh does not have: a link may belong to another one, or be mended by hand. */
import type { Spot, State } from './state.ts';
import type { Surface } from './surface.ts';

/** The state without points that are not on the surface; null where all are. */
export function withoutForeign(state: State, surface: Surface): State | null {
  const { sources, via, target, arrow, measures } = state;
  const has = (spot: Spot) => surface.has(spot);
  const all = [...sources, ...via, ...(target ? [target] : []), ...(arrow ? [arrow.from] : []), ...measures.flatMap(spotsIn)];
  if (all.every(has)) return null;
  return {
    ...state,
    sources: sources.filter(has),
    via: via.filter(has),
    target: target && has(target) ? target : null,
    arrow: arrow && has(arrow.from) ? arrow : null,
    measures: measures.filter((measure) => spotsIn(measure).every(has)),
  };
}

function spotsIn({ from, via, to }: State['measures'][number]): Spot[] {
  return [from, ...via, to];
}
