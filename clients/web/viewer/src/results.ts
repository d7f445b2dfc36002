/**
 * What the server has answered to the state: the mesh, the field, the path. Never in the
 * link; always to be had again from it.
 */
import type { Loop, MeshMetadata, MethodInfo, Path, Trace, Voronoi } from 'geodesicd-client';
import type { RegionLook } from './regions.ts';
import type { Cost } from './costs.ts';
import type { Line, Spot, State } from './state.ts';
import type { Surface } from './surface.ts';

/** A distance a source vertex (mesh units, +Infinity where unreached), as it was answered. */
export interface KnownField {
  readonly values: Float32Array;
  /** The place among the sources of each vertex's nearest; only with several sources. */
  readonly labels: Uint32Array | null;
  /** How many sources it has. */
  readonly sources: number;
  readonly max: number;
  /** Of the server's computing, in milliseconds; null where it had the field already. */
  readonly ms: number | null;
  readonly method: string;
  /** What its numbers are the costs of; null where they are lengths. */
  readonly cost: Cost | null;
  /** The server's sentences on it. */
  readonly warnings: readonly string[];
  /** What was asked, to tell whether it still is the state's. */
  readonly key: string;
}

/** The relative error of a field against the exact one, a number a vertex. */
export interface FieldError {
  readonly values: Float32Array;
  readonly mean: number;
  readonly most: number;
}

/** What is known of one method for the present sources. */
export interface Trial {
  readonly ms: number | null;
  readonly mean: number | null;
  readonly most: number | null;
}

/** The line that is drawn: paths from point to point, or the loop that they became. */
export interface DrawnLine {
  readonly points: Path['points'];
  /** Mesh units; null where no path leads on. */
  readonly length: number | null;
  /** Null while it is open. */
  readonly loop: Loop | null;
  readonly key: string;
}

export interface Results {
  readonly meshes: readonly MeshMetadata[];
  readonly methods: readonly MethodInfo[];
  readonly surface: Surface | null;
  /** Which queries the server has that not all do. */
  readonly offers: { readonly walls: boolean; readonly curves: boolean; readonly costs: boolean };
  readonly field: KnownField | null;
  readonly error: FieldError | null;
  /** Of several sources, each one's own field, for crisp borders between regions. */
  readonly apart: { readonly fields: readonly KnownField[]; /** Of the field of all. */ readonly key: string } | null;
  /** How regions of several sources look; null where they are not shown. */
  readonly regions: RegionLook | null;
  readonly trials: Readonly<Record<string, Trial>>;
  /** Whether the comparison of all methods was stopped before its end. */
  readonly stopped: boolean;
  readonly path: Path | null;
  /** The source that the path was asked from; of a line the path itself only says the line's first point. */
  readonly pathStart: Spot | Line | null;
  /** Whether the path is, or was until a moment ago, of other points than the present ones. */
  readonly stale: boolean;
  /** Of the last path: the server's computing, in milliseconds. */
  readonly pathMs: number | null;
  /** How far along the path somebody points, in mesh units. */
  readonly along: number | null;
  /** Whether the path's profile is open: then the path can be pointed at. */
  readonly profiled: boolean;
  readonly trace: Trace | null;
  /** Walls and curves as they lie on the surface, by what the state says of them. */
  readonly lines: ReadonlyMap<Line, Path['points']>;
  readonly drawn: DrawnLine | null;
  /** Why there is no loop, in the server's words. */
  readonly noLoop: string | null;
  /** What the disc measures, in mesh units; the outline is with the surface's own boundary. */
  readonly disc: { readonly radius: number; readonly area: number; readonly outline: number; readonly key: string } | null;
  readonly cells: { readonly answered: Voronoi; readonly key: string } | null;
  /** The paths of the list's measures, in their order; null while one is awaited. */
  readonly measured: readonly (Path | null)[];
}

/** Before anything is answered about what the state says of a mesh. */
export const UNANSWERED = {
  field: null,
  error: null,
  apart: null,
  regions: null,
  trials: {},
  stopped: false,
  path: null,
  pathStart: null,
  stale: false,
  pathMs: null,
  along: null,
  trace: null,
  lines: new Map(),
  drawn: null,
  noLoop: null,
  disc: null,
  cells: null,
  measured: [],
} as const satisfies Partial<Results>;

export const NOTHING: Results = {
  meshes: [],
  methods: [],
  surface: null,
  offers: { walls: false, curves: false, costs: false },
  profiled: false,
  ...UNANSWERED,
};

/** The surface of the state's mesh; null while it is on its way and another one is still drawn. */
export function surfaceOf({ mesh }: State, { surface }: Results): Surface | null {
  return surface?.id === mesh ? surface : null;
}

/** The error of `values` against `exact`, both a distance a vertex; where either is unreached it is 0. */
export function errorAgainst(values: Float32Array, exact: Float32Array): FieldError {
  const errors = new Float32Array(values.length);
  let sum = 0;
  let count = 0;
  let most = 0;
  for (let i = 0; i < values.length; i++) {
    const truth = exact[i]!;
    if (!(truth > 0 && truth < Infinity && values[i]! < Infinity)) continue;
    const error = Math.abs(values[i]! - truth) / truth;
    errors[i] = error;
    sum += error;
    count++;
    if (error > most) most = error;
  }
  return { values: errors, mean: count ? sum / count : 0, most };
}
