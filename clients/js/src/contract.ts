/**
 * The contract's types under short names. Whatever crosses the wire is typed by what is
 * generated from the server's OpenAPI document; nothing of it is written down twice.
 */
import type { components } from './generated/contract.js';

export type Schemas = components['schemas'];

/** What is known of a mesh: counts, bounds (mesh units), parts in source-vertex order. */
export type MeshMetadata = Schemas['Mesh'];
/** One drawn instance of one primitive: a run of source vertices and faces. */
export type MeshPart = Schemas['MeshPart'];
/** A material of the file, and how many faces have it. */
export type MeshMaterial = Schemas['MeshMaterial'];
/** A loop of the boundary; the one at place `k` of the metadata is the source `{ boundary: k }`. */
export type BoundaryLoop = Schemas['BoundaryLoop'];
/** A point found on the surface, with `snap_distance` from what was asked for, in mesh units. */
export type ResolvedPoint = Schemas['ResolvedPoint'];
export type PathPoint = Schemas['PathPoint'];
export type Isoline = Schemas['Isoline'];
export type Sample = Schemas['Sample'];
/** The name of a geodesic method, such as `wavefront` or `exact`. */
export type Method = Schemas['Method'];
/** A method as the server describes it, with the parameters that are its own. */
export type MethodInfo = Schemas['Methods']['methods'][number];
/** What costs are in: seconds, joules a kilogram, lengths or a unit of the table's own. */
export type CostUnit = Schemas['CostUnit'];
export type Job = Schemas['Job'];
export type JobState = Job['state'];
export type Status = Schemas['Status'];
export type ErrorCode = Schemas['ErrorCode'];
export type Problem = Schemas['Problem'];
export type Xyz = readonly [number, number, number] | readonly number[];

/** The queries that the API has; `/batch` takes any of them. */
export type QueryName = Schemas['BatchLine']['query'];
/** The formats that a reply may have. */
export type Format = Schemas['Format'];

/** What the label of a vertex is that no source reaches. */
export const UNREACHED = 0xffffffff;
