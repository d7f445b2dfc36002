/**
 * What each query takes, with the contract's names, and the value that it resolves to.
 * Lengths are in mesh units throughout.
 */
import type { CostUnit, Isoline, Method, PathPoint, ResolvedPoint, Sample, Schemas, Xyz } from './contract.js';
import type { WeightedRegion } from './costs.js';
import type { OneOrMore, Point, Source, SourceLines } from './points.js';
import type { Region, Wall } from './regions.js';

/** What one call may have beside its parameters. */
export interface CallOptions {
  /** Ends the call; the server then stops computing. */
  signal?: AbortSignal | undefined;
}

export interface QueryOptions extends CallOptions {
  /** Milliseconds after which the server gives up: GeodesicError `deadline`, status 504. */
  deadlineMs?: number | undefined;
}

/** What every query may have: the part of the surface that it is about. */
interface OnSurface {
  /** Only this is left of the surface; several are their union. */
  within?: OneOrMore<Region>;
  /** This is as if it were cut away. */
  forbid?: OneOrMore<Region>;
  /** No path crosses these lines. */
  walls?: OneOrMore<Wall>;
}

interface ByMethod extends OnSurface {
  /** How distances are computed; the server's default is `auto`. */
  method?: Method;
  /** Only with the method `steiner`. */
  points_per_edge?: Schemas['PointsPerEdge'];
  /** Only with the method `auto`. */
  bound?: Schemas['Bound'];
}

/**
 * Ways that are cheap instead of short. A segment costs its length, times the weight of its face,
 * times the rate of its slope; distances, `max` and levels are costs then. By `steiner` alone, which
 * needs not be named.
 */
interface AtACost {
  /** Of regions; where they overlap, the last counts. */
  weights?: OneOrMore<WeightedRegion>;
  /** One for each source face. */
  face_weights?: readonly number[];
  /** An attribute of the file's vertices, such as `_MUD`: a face's weight is the mean at its corners. */
  weight_attribute?: string;
  /** `tobler`, in seconds, or `energy`, in joules a kilogram, where lengths are metres; or slopes and what a unit of length costs there. */
  slope?: string | readonly (readonly [number, number])[];
  /** What is steeper, uphill or downhill, is not walked. */
  steepest?: number;
  /** Where up is; +Y without it. */
  up?: Xyz | string;
}

interface WithinTolerance {
  /** Only with the method `auto`: the largest relative error of a vertex's distance. */
  tolerance?: Schemas['ErrorAtMost'];
}

interface InDigits {
  /** Significant digits of numbers in JSON; all without it. */
  precision?: Schemas['Precision'];
}

export interface DistanceQuery extends ByMethod, WithinTolerance, AtACost {
  from: OneOrMore<Source | SourceLines>;
  /** What is farther counts as unreached. */
  max?: number;
  /** Say with each distance which source it is from. */
  labels?: boolean;
  /**
   * Below 0 inside `from`, which is one closed curve that separates the surface: on the smaller
   * side, by area.
   */
  signed?: boolean;
}

export interface DistancesAtQuery extends DistanceQuery, InDigits {
  at: OneOrMore<Point>;
}

export interface PathQuery extends ByMethod, InDigits, AtACost {
  from: Point | SourceLines;
  to: Point;
  via?: OneOrMore<Point>;
  refine?: Schemas['Refine'];
  /** Only with the method `steiner`. */
  tolerance?: Schemas['Tolerance'];
}

export interface TableQuery extends ByMethod, WithinTolerance, AtACost {
  /** The rows. */
  from: OneOrMore<Point | SourceLines>;
  /** The columns; without it the rows again. Of a line it is the least distance of all of it. */
  to?: OneOrMore<Point | SourceLines>;
  max?: number;
}

/** A table that arrives row by row. */
export interface TableRowsQuery extends TableQuery {
  /** From how many columns, from 8 to 300, whole fields are computed, and what is far estimated. */
  landmarks?: number;
}

/** What of a table is not farther than `max`. */
export interface SparseTableQuery extends TableQuery {
  max: number;
}

/** Exactly one of `levels`, `step` and `count`. */
export interface IsolinesQuery extends ByMethod, WithinTolerance, InDigits, AtACost {
  from: OneOrMore<Source | SourceLines>;
  levels?: OneOrMore<number>;
  step?: number;
  count?: number;
  max?: number;
}

export interface NearestQuery extends InDigits, OnSurface {
  point: OneOrMore<Point>;
}

/** Exactly one of `direction` and `angle` (radians). */
export interface TraceQuery extends InDigits, OnSurface {
  from: Point;
  direction?: Xyz | string;
  angle?: number;
  length: number;
}

/** Exactly one of `through`, `around` and `at`; `normal` only with `at`, `hull` not with `through`. */
export interface LoopQuery extends ByMethod, InDigits {
  /** Two points or more, joined by shortest paths in this order, and back to the first. */
  through?: readonly Point[];
  /** Three points or more, joined likewise and tightened to a closed geodesic. */
  around?: readonly Point[];
  /** Where a plane cuts the surface in a closed curve, which is tightened likewise. */
  at?: Point;
  /** At a right angle to the plane, of any length. */
  normal?: Xyz | string;
  /** The convex hull of the section instead, as a tape lies round hollows; with three points `around`, in their plane. */
  hull?: boolean;
  /** Only with the method `steiner`. */
  tolerance?: Schemas['Tolerance'];
}

export interface LogmapQuery extends ByMethod {
  from: Point;
  /** What is farther has no place; without it all has one that a path leads to. */
  radius?: number;
  /** The direction that becomes the x axis, radians, as `trace` has them; 0 without it. */
  angle?: number;
  /** Carry the direction of the x axis along each path: `directions`. */
  transport?: boolean;
  /** Only with the method `steiner`. */
  tolerance?: Schemas['Tolerance'];
}

export interface MeasureQuery extends ByMethod, WithinTolerance, InDigits {
  from: OneOrMore<Source | SourceLines>;
  /** Of the discs. Mesh units. */
  radii?: OneOrMore<number>;
  /** What is farther is not measured. Mesh units. */
  max?: number;
}

export interface ExtentQuery extends ByMethod, WithinTolerance, InDigits {
  of: Schemas['ExtentOf'];
  /** How many fields may be computed; 100 without it. */
  fields?: number;
}

export interface VoronoiQuery extends ByMethod, WithinTolerance, InDigits {
  /** The sites. */
  from: OneOrMore<Source | SourceLines>;
  /** Rounds of Lloyd's algorithm, each of which moves the sites, which are points then, to their cells' centroids. */
  relax?: number;
}

export interface SamplesQuery extends ByMethod, WithinTolerance, InDigits {
  count: number;
  from?: OneOrMore<Source | SourceLines>;
}

/** How a picture is drawn; see the contract. */
export interface Drawing {
  /** Pixels; 1200 without it. */
  width?: Schemas['Side'];
  /** Pixels; 900 without it. */
  height?: Schemas['Side'];
  /** A side (`top`) or `AZIMUTH,ELEVATION` in degrees. */
  view?: Schemas['View'];
  colormap?: Schemas['ColourMap'];
  stripes?: Schemas['Stripes'];
}

type Of<Name extends string, Query> = { of: Name } & Omit<Query, 'precision'>;
type FieldQuery = Omit<DistanceQuery, 'labels'>;
/** Each vertex's mean distance over the surface: `extent` of `means`. */
type MeansOf = Of<'means', Omit<ExtentQuery, 'of'>>;

export type PictureQuery = Drawing &
  (
    | Of<'distance', FieldQuery>
    | Of<'path', PathQuery>
    | Of<'voronoi', VoronoiQuery>
    | Of<'trace', TraceQuery>
    | Of<'loop', LoopQuery>
    | MeansOf
  );

export type GlbQuery =
  | { of: 'geometry' }
  | ((
      | Of<'distance', FieldQuery>
      | Of<'path', PathQuery>
      | Of<'isolines', IsolinesQuery>
      | Of<'measure', MeasureQuery>
      | MeansOf
      | Of<'voronoi', VoronoiQuery & { part?: Schemas['VoronoiPart'] }>
      | Of<'trace', TraceQuery>
      | Of<'loop', LoopQuery>
      | Of<'logmap', LogmapQuery>
    ) & { colormap?: Schemas['ColourMap'] });

/** What goes into the file that was uploaded, and what it is called there. */
export type AnnotatedQuery = { attribute?: Schemas['AttributeName'] } & (
  | (Of<'distance', DistanceQuery> & { label_attribute?: Schemas['AttributeName'] })
  | Of<'logmap', LogmapQuery>
  | MeansOf
);

type Bare =
  | Of<'distance', FieldQuery & { at?: OneOrMore<Point> }>
  | MeansOf
  | Of<'path', PathQuery>
  | Of<'table', TableQuery>
  | Of<'trace', TraceQuery>
  | Of<'loop', LoopQuery>;
export type ArrayFormat = 'f32' | 'f64' | 'u16' | 'npy';
/** A query whose reply is one bare array; `u16` is for `distance`, `means` and `table` only. */
export type ArrayQuery = Bare & { format: ArrayFormat };
/** A query whose reply is a frame. */
export type FrameQuery =
  | Bare
  | Of<'distance', DistanceQuery & { at?: OneOrMore<Point> }>
  | Of<'logmap', LogmapQuery>
  | { of: 'geometry' };

/** Milliseconds that the server spent in each stage, of those that took any. */
export type Timing = Partial<
  Record<'queue' | 'load' | 'prepare' | 'solve' | 'trace' | 'encode', number>
>;

/** What replies to queries have in common. */
export interface Told {
  timing: Timing;
  /** Whether the distance field was there already; null where none is kept. */
  cache: 'hit' | 'miss' | null;
  /** What the server thinks odd about the question, a sentence each: a point far from the surface. */
  warnings: string[];
}

export type Precision = 'f32' | 'f64';
export type Floats<P extends Precision> = P extends 'f64' ? Float64Array : Float32Array;

/** A distance a source vertex, +Infinity where unreached. */
export interface Field<P extends Precision = 'f32'> extends Told {
  mesh: string;
  method: Method;
  from: ResolvedPoint[];
  /** Length: the mesh's `vertices`. Mesh units. */
  values: Floats<P>;
  /** The place in `from` of each vertex's nearest source; UNREACHED where there is none. */
  labels?: Uint32Array;
  reached: number;
  /** The greatest finite distance; null when nothing was reached. */
  max: number | null;
  /** The source vertex where that is. */
  farthest: number | null;
  /** What costs are in; undefined of lengths. */
  unit?: CostUnit;
  /** Whether distances are below 0 on the inner side of the curve. */
  signed?: true;
}

export type DistancesAt = Schemas['DistanceReply'] & Told;
export type Path = Schemas['PathReply'] & Told;
export type Isolines = Schemas['IsolinesReply'] & Told;
export type Nearest = Schemas['NearestReply'] & Told;
export type Trace = Schemas['TraceReply'] & Told;
export type Loop = Schemas['LoopReply'] & Told;
export type Samples = Schemas['SamplesReply'] & Told;
export type Measure = Schemas['MeasureReply'] & Told;
export type Extent = Schemas['ExtentReply'] & Told;
export type Voronoi = Schemas['VoronoiReply'] & Told;
export type { Isoline, PathPoint, Sample };

/** Distances from each row's point to each column's, row after row; +Infinity where unreached. */
export interface Table extends Told {
  mesh: string;
  method: Method;
  rows: ResolvedPoint[];
  columns: ResolvedPoint[];
  /** Length: rows times columns. Mesh units. */
  distances: Float64Array;
  /** What costs are in; undefined of lengths. */
  unit?: CostUnit;
}

/** A row of a table that arrives row by row: its distance to each column, +Infinity: unreached. */
export interface TableRow {
  row: number;
  distances: Float64Array;
  /** Only of a table with `landmarks`. */
  estimated?: Estimated;
}

/** By how much entries were off that were compared, as parts of the distances. */
export interface Estimated {
  /** How many columns have whole fields. */
  landmarks: number;
  mean: number;
  percentile_99: number;
  max: number;
  /** How many were compared. */
  entries: number;
}

/**
 * Distances within a bound, by compressed sparse rows: those of row `i` are `data` from
 * `indptr[i]` to before `indptr[i + 1]`, and `indices` has their columns, ascending.
 */
export interface SparseTable extends Told {
  mesh: string;
  method: Method;
  rows: ResolvedPoint[];
  columns: ResolvedPoint[];
  data: Float64Array;
  indices: Uint32Array;
  indptr: Uint32Array;
  /** What costs are in; undefined of lengths. */
  unit?: CostUnit;
}

/** The surface round a point, laid into the plane: a place for each of `vertices`. */
export interface Logmap extends Told {
  mesh: string;
  method: Method;
  from: ResolvedPoint;
  /** Of the x axis, radians, as `trace` has them. */
  angle: number;
  /** The one asked for, or else the greatest distance. Mesh units. */
  radius: number;
  /** Of all directions at the point, radians. */
  total_angle: number;
  /** Whether no boundary is in the way at the point. */
  all_round: boolean;
  /** The source vertices that have a place, ascending. */
  vertices: Uint32Array;
  /** The lengths of their paths. Mesh units. */
  distances: Float64Array;
  /** Those at which the paths leave the point, radians, as `trace` has them. */
  angles: Float64Array;
  /** 1 where `trace` by the angle and the distance leads to the vertex, else 0. */
  straight: Uint32Array;
  /** x and y of each, y to the left of x. Mesh units. */
  coordinates: Float64Array;
  /** With `transport`: x, y and z of the direction of the x axis at the point, carried to each. */
  directions?: Float64Array;
}

/** What the server computes on, in source-vertex and source-face order. */
export interface Geometry<P extends Precision = 'f32'> {
  /** x, y, z of each vertex, in mesh units. */
  positions: Floats<P>;
  /** Three vertices a face. */
  triangles: Uint32Array;
}

/** For each query: what it takes and what it resolves to. */
export interface Queries {
  distance: { takes: DistanceQuery; gives: Field };
  distancesAt: { takes: DistancesAtQuery; gives: DistancesAt };
  path: { takes: PathQuery; gives: Path };
  table: { takes: TableQuery; gives: Table };
  isolines: { takes: IsolinesQuery; gives: Isolines };
  nearest: { takes: NearestQuery; gives: Nearest };
  trace: { takes: TraceQuery; gives: Trace };
  loop: { takes: LoopQuery; gives: Loop };
  logmap: { takes: LogmapQuery; gives: Logmap };
  samples: { takes: SamplesQuery; gives: Samples };
  measure: { takes: MeasureQuery; gives: Measure };
  extent: { takes: ExtentQuery; gives: Extent };
  voronoi: { takes: VoronoiQuery; gives: Voronoi };
  picture: { takes: PictureQuery; gives: Blob };
  glb: { takes: GlbQuery; gives: ArrayBuffer };
  annotated: { takes: AnnotatedQuery; gives: ArrayBuffer };
  prepare: { takes: object; gives: Schemas['Mesh'] };
}

/** A query as a value, for `job`: its name and its parameters. */
export type Ask<Name extends keyof Queries> = { query: Name } & Queries[Name]['takes'];
