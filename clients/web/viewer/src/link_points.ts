/** The points of a link on the mesh that it speaks of, which is only known once that is here. */
import { paintedOn, paintedText } from './painted.ts';
import { spotText } from './spot_text.ts';
import { START, type Line, type Measure, type Spot, type State } from './state.ts';
import type { Surface } from './surface.ts';

export interface LinkPoints {
  readonly points: Pick<State, 'sources' | 'via' | 'target' | 'arrow' | 'loop' | 'painted' | 'curves' | 'measures' | 'tool'>;
  /** Those that the mesh does not have, as the link says them; `kept` for a measure. */
  readonly lost: readonly string[];
}

/** The first of two lists where they are equal, so that nobody takes them for a change. */
function same<T>(one: readonly T[], other: readonly T[]): readonly T[] {
  return one.length === other.length && one.every((each, index) => each === other[index]) ? one : other;
}

/** Vertices become places on faces; what the mesh does not have is left out. */
export function pointsOn(surface: Surface, state: State): LinkPoints {
  const lost: string[] = [];
  const settled = (spot: Spot, name: string): Spot[] => {
    const found = spot.vertex === undefined ? spot : surface.spotAt(spot.vertex);
    if (found && surface.has(found)) return [found];
    lost.push(`${name}=${spotText(spot)}`);
    return [];
  };
  const measureOn = (measure: Measure): Measure[] => {
    const all = [measure.from, ...measure.via, measure.to];
    const spots = all.flatMap((spot) => settled(spot, 'kept'));
    if (spots.length < all.length) return [];
    // Paths are known by their measures: one that needs nothing stays the same.
    if (same(all, spots) === all) return [measure];
    return [{ ...measure, from: spots[0]!, via: spots.slice(1, -1), to: spots.at(-1)! }];
  };
  const sources = same(state.sources, state.sources.flatMap((spot) => settled(spot, 'from')));
  const { target, arrow, loop } = state;
  const drawn = loop && same(loop.points, loop.points.flatMap((spot) => settled(spot, 'loop')));
  const lineOn = (name: string) => (line: Line): Line[] => {
    const points = same(line.points, line.points.flatMap((spot) => settled(spot, name)));
    // Of fewer points it would be another one.
    return points === line.points ? [line] : points.length < line.points.length ? [] : [{ ...line, points }];
  };
  const walls = same(state.painted.walls, state.painted.walls.flatMap(lineOn('wall')));
  const faces = paintedOn(state.painted, surface.about.faces);
  const painted = walls === faces.walls ? faces : { ...faces, walls };
  if (faces !== state.painted) lost.push(paintedText(state.painted).replace(':', '=').slice(0, 40));
  const [start] = arrow ? settled(arrow.from, 'arrow') : [];
  return {
    points: {
      sources,
      via: same(state.via, state.via.flatMap((spot) => settled(spot, 'via'))),
      target: (target && settled(target, 'to')[0]) ?? null,
      arrow: !arrow || !start ? null : start === arrow.from ? arrow : { ...arrow, from: start },
      // A loop of fewer points would be another one.
      loop: !loop || drawn!.length < loop.points.length ? null : drawn === loop.points ? loop : { ...loop, points: drawn! },
      painted,
      curves: same(state.curves, state.curves.flatMap(lineOn('curve'))),
      measures: same(state.measures, state.measures.flatMap(measureOn)),
      tool: sources.length ? state.tool : START.tool,
    },
    lost,
  };
}
