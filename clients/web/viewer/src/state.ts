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
export type Tool = 'source' | 'add' | 'target' | 'via' | 'arrow';
export type Axis = 'x' | 'y' | 'z';
export type Show = 'distance' | 'regions' | 'error';

/** A straightest geodesic: from where, whither (mesh axes, any length), how far (mesh units). */
export interface Arrow {
  readonly from: Spot;
  readonly direction: Xyz;
  readonly length: number;
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
}

export interface State {
  readonly mesh: string | null;
  readonly sources: readonly Spot[];
  readonly via: readonly Spot[];
  readonly target: Spot | null;
  readonly arrow: Arrow | null;
  readonly measures: readonly Measure[];
  readonly method: string;
  /** Points that the method `steiner` adds inside each edge; null for its default. */
  readonly pointsPerEdge: number | null;
  readonly refine: boolean;
  readonly show: Show;
  readonly colours: 'viridis' | 'turbo';
  /** About how many isolines; 0 for none. */
  readonly lines: number;
  /** Whether distances stand along the path. */
  readonly ticks: boolean;
  /** Whether the mesh's edges are drawn. */
  readonly edges: boolean;
  readonly tool: Tool;
  /** Which of the mesh's axes is up; null for the page's guess. */
  readonly up: Axis | null;
  /** Position and target of the camera, in units of the mesh's radius about its middle. */
  readonly camera: readonly number[] | null;
}

/** The server takes no more. */
export const MOST_SOURCES = 1000;
export const MOST_VIA = 100;
/** Paths in the list: each is asked for. */
export const MOST_MEASURES = 50;
/** So many regions have each their own field, for crisp borders; and so many slots has the shader. */
export const REGIONS = 8;

export const START: State = {
  mesh: null,
  sources: [],
  via: [],
  target: null,
  arrow: null,
  measures: [],
  method: 'auto',
  pointsPerEdge: null,
  refine: true,
  show: 'distance',
  colours: 'viridis',
  lines: 24,
  ticks: true,
  edges: false,
  tool: 'source',
  up: null,
  camera: null,
};

/** What a new mesh takes away: all that stands on the old one. */
export const WITHOUT_POINTS = {
  sources: [],
  via: [],
  target: null,
  arrow: null,
  measures: [],
  show: 'distance',
  tool: 'source',
} as const satisfies Partial<State>;

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
