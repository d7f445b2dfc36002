/**
 * Regions and walls as clients say them, and their form in a URL. In JSON they are as they are,
 * but for the points of their lines.
 */
import { pointInJson, pointsInUrl, type Source } from './points.js';
import { isWholeFaces, wholeFacesInUrl, type WholeFaces } from './whole_faces.js';

/**
 * A part of a surface: source faces and ranges of them with both ends, a part or a material of the
 * file by its place in the metadata or by name, those with a label in the file, the faces whose centroids are in a ball or in a box along the
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
  if (isWholeFaces(region)) return wholeFacesInUrl(region);
  const points = 'inside' in region ? lineInUrl(region.inside) : undefined;
  return points === undefined ? undefined : `inside:${points}`;
}

/** The wall in a URL, likewise. */
export function wallInUrl(wall: Wall): string | undefined {
  if (typeof wall === 'string') return wall;
  if (typeof wall !== 'object' || wall === null || Object.keys(wall).length !== 1) return undefined;
  return lineInUrl(wall.points);
}

/** A region, a wall or several in JSON: numbers among a line's points are vertices. */
export function regionInJson(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(regionInJson);
  if (typeof value !== 'object' || value === null) return value;
  return Object.fromEntries(
    Object.entries(value).map(([name, of]) => [
      name,
      (name === 'inside' || name === 'points') && Array.isArray(of) ? of.map(pointInJson) : of,
    ]),
  );
}

function lineInUrl(points: unknown): string | undefined {
  const texts = pointsInUrl(points);
  return texts?.length ? texts.join(';') : undefined;
}
