/** The client of geodesicd, for browsers and Node. What three.js needs is in `./three`. */
export { dequantise, type Shaped, type TypedArray } from './arrays.js';
export type { ArrivingGeometry } from './arriving.js';
export type { BatchAnswer, BatchQuery } from './batch.js';
export { GeodesicClient, type ClientOptions } from './client.js';
export { colourAt, COLOUR_MAPS_GLSL, type ColourMap, type Rgb } from './colour_maps.js';
export {
  UNREACHED,
  type ErrorCode,
  type BoundaryLoop,
  type CostUnit,
  type Format,
  type Isoline,
  type Job,
  type JobState,
  type MeshMaterial,
  type MeshMetadata,
  type MeshPart,
  type Method,
  type MethodInfo,
  type PathPoint,
  type Problem,
  type QueryName,
  type ResolvedPoint,
  type Sample,
  type Schemas,
  type Status,
  type Xyz,
} from './contract.js';
export type { WeightedRegion } from './costs.js';
export { GeodesicError, NetworkError } from './errors.js';
export { decodeFrame, type Frame, type FrameArray, type FrameHeader } from './frame.js';
export type { JobOptions } from './jobs.js';
export { decodeNpy } from './npy.js';
export { plyOf, type GeometryLike, type MeshArrays } from './ply.js';
export type { OneOrMore, Point, Source, SourceLines } from './points.js';
export type { Region, Wall } from './regions.js';
export type * from './queries.js';
export { parseTiming, type BareArray, type ToldFrame } from './replies.js';
export type { Call, Reply } from './transport.js';
export {
  digestOf,
  type MeshData,
  type NamedFile,
  type Reading,
  type Uploadable,
  type UploadJobOptions,
  type UploadOptions,
} from './upload.js';
export type { WholeFaces } from './whole_faces.js';
