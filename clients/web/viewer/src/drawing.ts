/** What is done with the line that is drawn: more points, an end, a tape round its one point, a wall or a source of it. */
import { Vector3, type PerspectiveCamera } from 'three';
import { MOST_LINES, MOST_LOOP, type Axis, type Drawn, type Spot, type State, type Xyz } from './state.ts';
import type { Surface } from './surface.ts';

/** Across which the plane of a tape stands: an axis, or so that it is seen as a level line. */
export type Across = Axis | 'view';

const AXES: Readonly<Record<Axis, Xyz>> = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

/**
 * With more points; a line that is closed is done, and another one begins. `full`: it takes no more, and those
 * beyond are left out.
 */
export function withPoints(drawn: Drawn | null, spots: readonly Spot[]): { line: Drawn; full: boolean } {
  const points = [...(drawn?.kind === 'open' ? drawn.points : []), ...spots];
  return { line: { kind: 'open', points: points.slice(0, MOST_LOOP), normal: null }, full: points.length > MOST_LOOP };
}

/** Closed through its points; as it is where that cannot be. */
export function closed(drawn: Drawn): Drawn {
  return drawn.kind === 'open' && drawn.points.length > 1 ? { ...drawn, kind: 'through' } : drawn;
}

/** As a wall or a source of the state in place of what was drawn; null where that takes no more. */
export function usedAs(as: 'wall' | 'curve', drawn: Drawn, { painted, curves }: State): Partial<State> | null {
  const line = { points: drawn.points, closed: drawn.kind === 'through' };
  const lines = as === 'wall' ? painted.walls : curves;
  if (lines.length >= MOST_LINES) return null;
  return { loop: null, ...(as === 'wall' ? { painted: { ...painted, walls: [...lines, line] } } : { curves: [...lines, line] }) };
}

/** A loop round its first point, in a plane; what it was stays where it was round a point already. */
export function roundPoint(drawn: Drawn, across: Across, surface: Surface, camera: PerspectiveCamera): Drawn {
  const [spot] = drawn.points;
  const normal = across === 'view' ? levelAt(surface.placeOf(spot!), camera) : AXES[across];
  return { kind: drawn.kind === 'tape' ? 'tape' : 'plane', points: [spot!], normal };
}

/** At a right angle to the plane through the eye and a place in which lines across the page lie. */
function levelAt(place: Vector3, camera: PerspectiveCamera): Xyz {
  const across = new Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
  const normal = across.cross(place.sub(camera.position)).normalize();
  return normal.toArray().map((part) => Number(part.toFixed(5))) as unknown as Xyz;
}
