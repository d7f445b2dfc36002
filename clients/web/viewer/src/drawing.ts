/** What is done with the line that is drawn: another point, an end, a tape round its one point. */
import { Vector3, type PerspectiveCamera } from 'three';
import { MOST_LOOP, type Axis, type Drawn, type Spot, type Xyz } from './state.ts';
import type { Surface } from './surface.ts';

/** Across which the plane of a tape stands: an axis, or so that it is seen as a level line. */
export type Across = Axis | 'view';

const AXES: Readonly<Record<Axis, Xyz>> = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

/** With one point more; a line that is closed is done, and another one begins. Null where it takes no more. */
export function withPoint(drawn: Drawn | null, spot: Spot): Drawn | null {
  const points = drawn?.kind === 'open' ? drawn.points : [];
  return points.length < MOST_LOOP ? { kind: 'open', points: [...points, spot], normal: null } : null;
}

/** Closed through its points; as it is where that cannot be. */
export function closed(drawn: Drawn): Drawn {
  return drawn.kind === 'open' && drawn.points.length > 1 ? { ...drawn, kind: 'through' } : drawn;
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
