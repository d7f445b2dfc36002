/** What a way costs, as clients say it, and its form in a URL. In JSON it is as it is. */
import { regionInUrl } from './regions.js';
import type { WholeFaces } from './whole_faces.js';

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
