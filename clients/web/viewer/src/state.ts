/**
 * What the page shows, as one plain value: the link reproduces exactly this. A store
 * holds it; whoever changes it says which parts, and all who listen are told at once.
 * Points are places on faces of the file, so they stay exact through any link.
 */

/** A place on a source face, by the weights of its corners. */
export interface Spot {
  readonly face: number;
  readonly bary: readonly [number, number, number];
  /** Only in a link whose mesh is not here yet: the vertex that is meant; the face is -1. */
  readonly vertex?: number;
}

export type Xyz = readonly [number, number, number];
export type Tool = 'source' | 'add' | 'target' | 'via' | 'arrow' | 'loop' | 'brush';
export type Axis = 'x' | 'y' | 'z';
/** Ways on foot that cost least: time (`tobler`) or energy, by the slope against an axis of the mesh. */
export interface Walking {
  readonly by: 'tobler' | 'energy';
  readonly up: Axis;
}

export type Show = 'distance' | 'regions' | 'cells' | 'error';

/** Whether ways are to be cheap, by slopes or by weights of faces, and not short. */
export function byCost({ walking, painted }: Pick<State, 'walking' | 'painted'>): boolean {
  return walking !== null || isWeighted(painted);
}

/** Whether paths over some faces cost something else than their length. */
export function isWeighted({ as, weight, faces }: Painted): boolean {
  return as === 'weights' && weight !== 1 && faces.length > 0;
}

/** Cells are those of points, and of lengths. */
export function mayHaveCells(state: State): boolean {
  return state.sources.length > 1 && !state.curves.length && !byCost(state);
}

/** Whether the surface is coloured by the nearest source. */
export function byRegion(show: Show): boolean {
  return show === 'regions' || show === 'cells';
}

/** A straightest geodesic: from where, whither (mesh axes, any length), how far (mesh units). */
export interface Arrow {
  readonly from: Spot;
  readonly direction: Xyz;
  readonly length: number;
}

/**
 * A line that is drawn point by point, and what closes it. `open`: shortest paths from point to point;
 * `through`: and back to the first; `around`: the same, tightened; `plane`: tightened from where a plane
 * through its one point cuts the surface; `tape`: the convex hull of that cut.
 */
export interface Drawn {
  readonly kind: 'open' | 'through' | 'around' | 'plane' | 'tape';
  readonly points: readonly Spot[];
  /** At a right angle to the plane (mesh axes), of `plane` and `tape`. */
  readonly normal: Xyz | null;
}

/** Whether it lies round its one point, by a plane. */
export function isPlanar({ kind }: Pick<Drawn, 'kind'>): boolean {
  return kind === 'plane' || kind === 'tape';
}

/** A line on the surface, of shortest paths from point to point; closed: and back to the first. */
export interface Line {
  readonly points: readonly Spot[];
  readonly closed: boolean;
}

/**
 * Faces that are painted, and walls. Queries may not touch the faces, or are about no others, or paths over them cost
 * more. None: the whole surface.
 */
export interface Painted {
  readonly as: 'forbid' | 'within' | 'weights';
  /** How many times its length a path costs on them, as `weights`. */
  readonly weight: number;
  /** Numbers of faces, ascending, as ranges with both ends. */
  readonly faces: readonly (readonly [number, number])[];
  /** What paths may not cross. */
  readonly walls: readonly Line[];
}

/** A path that was kept in the list. Its length is asked for anew when a link brings it. */
export interface Measure {
  readonly from: Spot;
  readonly via: readonly Spot[];
  readonly to: Spot;
  readonly method: string;
  /** As in the state that it was kept of. */
  readonly pointsPerEdge: number | null;
  readonly refine: boolean;
  readonly painted: Painted;
}

export interface State {
  readonly mesh: string | null;
  readonly sources: readonly Spot[];
  readonly via: readonly Spot[];
  readonly target: Spot | null;
  readonly arrow: Arrow | null;
  readonly loop: Drawn | null;
  readonly painted: Painted;
  /** Sources that are lines. */
  readonly curves: readonly Line[];
  /** Radius of the disc that is measured, in mesh units; null for none. */
  readonly disc: number | null;
  readonly measures: readonly Measure[];
  readonly method: string;
  /** Points that the method `steiner` adds inside each edge; null for its default. */
  readonly pointsPerEdge: number | null;
  readonly refine: boolean;
  /** What ways on foot are to have least; null where slopes cost nothing. */
  readonly walking: Walking | null;
  readonly show: Show;
  readonly colours: 'viridis' | 'turbo';
  /** About how many isolines; 0 for none. */
  readonly lines: number;
  /** Whether distances stand along the path. */
  readonly ticks: boolean;
  /** Whether the mesh's edges are drawn. */
  readonly edges: boolean;
  readonly tool: Tool;
  /** Radius of the brush, in parts of the mesh's. */
  readonly brush: number;
  /** Whether the brush takes paint away. */
  readonly erasing: boolean;
  /** Which of the mesh's axes is up; null for the page's guess. */
  readonly up: Axis | null;
  /** Position and target of the camera, in units of the mesh's radius about its middle. */
  readonly camera: readonly number[] | null;
}

/** The server takes no more. */
export const MOST_SOURCES = 1000;
export const MOST_VIA = 100;
export const MOST_LOOP = 100;
/** Walls, and curves: each is asked for to be drawn. */
export const MOST_LINES = 50;
/** Paths in the list: each is asked for. */
export const MOST_MEASURES = 50;
/** So many regions have each their own field, for crisp borders; and so many slots has the shader. */
export const REGIONS = 8;

export const UNPAINTED: Painted = { as: 'forbid', weight: 3, faces: [], walls: [] };

export const START: State = {
  mesh: null,
  sources: [],
  via: [],
  target: null,
  arrow: null,
  loop: null,
  painted: UNPAINTED,
  curves: [],
  disc: null,
  measures: [],
  method: 'auto',
  pointsPerEdge: null,
  refine: true,
  walking: null,
  show: 'distance',
  colours: 'viridis',
  lines: 24,
  ticks: true,
  edges: false,
  tool: 'source',
  brush: 0.08,
  erasing: false,
  up: null,
  camera: null,
};

/** What is placed on the surface. */
export const POINTS = ['sources', 'via', 'target', 'arrow', 'loop', 'curves'] as const;

/** What is left when the points are cleared. */
export const CLEARED = {
  sources: [],
  via: [],
  target: null,
  arrow: null,
  loop: null,
  curves: [],
  disc: null,
  show: 'distance',
  tool: 'source',
} as const satisfies Partial<State>;

/** What a new mesh takes away: all that stands on the old one, and ways on foot: up is another axis there. */
export const WITHOUT_POINTS = { ...CLEARED, painted: UNPAINTED, measures: [], walking: null } as const satisfies Partial<State>;

/** Whether one of these parts is another than before. */
export function differ<T>(now: T, before: T, ...names: readonly (keyof T)[]): boolean {
  return names.some((name) => now[name] !== before[name]);
}

/** Holds one plain value; whoever listens is told of each change, after it. */
export class Store<T extends object> {
  #value: T;
  readonly #listeners: ((value: T, before: T) => void)[] = [];

  constructor(value: T) {
    this.#value = value;
  }

  get value(): T {
    return this.#value;
  }

  /** Sets some parts; the listeners are called in the order in which they came. */
  set(parts: Partial<T>): void {
    const before = this.#value;
    const names = Object.keys(parts) as (keyof T)[];
    if (names.every((name) => parts[name] === before[name])) return;
    this.#value = { ...before, ...parts };
    const now = this.#value;
    for (const listener of this.#listeners) listener(now, before);
  }

  listen(listener: (value: T, before: T) => void): void {
    this.#listeners.push(listener);
  }
}
