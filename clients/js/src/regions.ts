/**
 * Regions as clients say them, and their form in a URL. In JSON they are as they are.
 */
import type { Xyz } from './contract.js';

/**
 * A part of a surface: source faces and ranges of them with both ends, a part of the file by its
 * place in the metadata's `parts`, the faces whose centroids are in a ball or in a box along the
 * axes, or a text in the grammar of URLs (`faces:0-99`).
 */
export type Region =
  | string
  | { readonly faces: readonly (number | readonly [number, number])[] }
  | { readonly part: number }
  | { readonly sphere: { readonly center: Xyz; readonly radius: number } }
  | { readonly box: { readonly min: Xyz; readonly max: Xyz } };

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
  return undefined;
}

function isPlace(value: unknown): value is Xyz {
  return Array.isArray(value) && value.length === 3;
}
