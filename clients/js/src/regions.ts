/**
 * Regions as clients say them, and their form in a URL. In JSON they are as they are.
 */
import type { Xyz } from './contract.js';
import { pointInJson, pointInUrl, type Source } from './points.js';

/** Faces by their numbers, a part of the file, or those whose middle a sphere or a box holds. */
export type WholeFaces =
  | { readonly faces: readonly (number | readonly [number, number])[] }
  | { readonly part: number }
  | { readonly sphere: { readonly center: Xyz; readonly radius: number } }
  | { readonly box: { readonly min: Xyz; readonly max: Xyz } };

/**
 * A part of a surface: source faces and ranges of them with both ends, a part of the file by its
 * place in the metadata's `parts`, the faces whose centroids are in a ball or in a box along the
 * axes, what a line through points and back to the first goes round, or a text in the grammar of
 * URLs (`faces:0-99`).
 */
export type Region = string | WholeFaces | { readonly inside: readonly Source[] };

/**
 * A line that no path crosses, from point to point by shortest paths, closed if it ends with the
 * point that it begins with; or its text (`v:1;v:2`).
 */
export type Wall = string | { readonly points: readonly Source[] };

/** The region in a URL; undefined where the grammar of URLs cannot say it. */
export function regionInUrl(region: Region): string | undefined {
  if (typeof region === 'string') return region;
  if (typeof region !== 'object' || region === null || Object.keys(region).length !== 1) {
    return undefined;
  }
  if ('faces' in region && Array.isArray(region.faces) && region.faces.length > 0) {
    return `faces:${region.faces.map((one) => (typeof one === 'number' ? one : one.join('-'))).join(',')}`;
  }
  if ('part' in region) return `part:${region.part}`;
  // What is not well formed goes as JSON, for the server to refuse it.
  if ('sphere' in region && isPlace(region.sphere?.center) && Object.keys(region.sphere).length === 2) {
    return `sphere:${[...region.sphere.center, region.sphere.radius].join(',')}`;
  }
  if ('box' in region && isPlace(region.box?.min) && isPlace(region.box.max) && Object.keys(region.box).length === 2) {
    return `box:${[...region.box.min, ...region.box.max].join(',')}`;
  }
  if ('inside' in region) {
    const points = lineInUrl(region.inside);
    return points === undefined ? undefined : `inside:${points}`;
  }
  return undefined;
}

/** The wall in a URL, likewise. */
export function wallInUrl(wall: Wall): string | undefined {
  if (typeof wall === 'string') return wall;
  if (typeof wall !== 'object' || wall === null || Object.keys(wall).length !== 1) return undefined;
  return lineInUrl(wall.points);
}

/** In JSON, numbers among a line's points are vertices. */
export function lineInJson(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(lineInJson);
  if (typeof value !== 'object' || value === null) return value;
  return Object.fromEntries(
    Object.entries(value).map(([name, of]) => [
      name,
      (name === 'inside' || name === 'points') && Array.isArray(of) ? of.map(pointInJson) : of,
    ]),
  );
}

function lineInUrl(points: unknown): string | undefined {
  if (!Array.isArray(points) || points.length === 0) return undefined;
  const texts = points.map((point) =>
    typeof point === 'object' || typeof point === 'number' || typeof point === 'string'
      ? pointInUrl(point as Source)
      : undefined,
  );
  return texts.includes(undefined) ? undefined : texts.join(';');
}

/** A weight of a region: what a unit of length costs there; or a text, `3*faces:0-99`. */
export type WeightedRegion = string | { readonly weight: number; readonly region: string | WholeFaces };

/** The weight in a URL; undefined where the grammar of URLs cannot say it. */
export function weightInUrl(weighted: WeightedRegion): string | undefined {
  if (typeof weighted === 'string') return weighted;
  if (typeof weighted !== 'object' || weighted === null || Object.keys(weighted).length !== 2) {
    return undefined;
  }
  const region = weighted.region === undefined ? undefined : regionInUrl(weighted.region);
  return region === undefined || typeof weighted.weight !== 'number' ? undefined : `${weighted.weight}*${region}`;
}

/** A table of slopes in a URL; undefined where the grammar of URLs cannot say it. */
export function slopeInUrl(slope: unknown): string | undefined {
  if (typeof slope === 'string') return slope;
  if (!Array.isArray(slope) || slope.length === 0) return undefined;
  const isPair = (one: unknown) => Array.isArray(one) && one.length === 2 && one.every((n) => typeof n === 'number');
  return slope.every(isPair) ? slope.map((pair: unknown[]) => pair.join(':')).join(',') : undefined;
}

function isPlace(value: unknown): value is Xyz {
  return Array.isArray(value) && value.length === 3;
}
