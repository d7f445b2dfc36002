/**
 * Sets of whole faces: as regions, as sources, and as what weights are given to. In JSON they are
 * as they are.
 */
import type { Xyz } from './contract.js';

/**
 * Faces by their numbers, a part or a material of the file, or those whose middle a sphere or a box
 * holds. Parts and materials are said by their place in the metadata, or by name, which means all
 * that have it; the material `null` is that of faces without one. A label is a number that all three
 * corners of a face have in an attribute of the file.
 */
export type WholeFaces =
  | { readonly faces: readonly (number | readonly [number, number])[] }
  | { readonly part: number | string }
  | { readonly material: number | string | null }
  | { readonly label: { readonly attribute: string; readonly value: number } }
  | { readonly sphere: { readonly center: Xyz; readonly radius: number } }
  | { readonly box: { readonly min: Xyz; readonly max: Xyz } };

/** Whether a value is to be a set of whole faces, well formed or not. */
export function isWholeFaces(value: object): value is WholeFaces {
  return ['faces', 'part', 'material', 'label', 'sphere', 'box'].some((kind) => kind in value);
}

/** The faces in a URL. What is not well formed goes as JSON, for the server to refuse it. */
export function wholeFacesInUrl(value: WholeFaces): string | undefined {
  if (Object.keys(value).length !== 1) return undefined;
  if ('faces' in value && Array.isArray(value.faces) && value.faces.length > 0) {
    return `faces:${value.faces.map((one) => (typeof one === 'number' ? one : one.join('-'))).join(',')}`;
  }
  if ('part' in value) return `part:${placeOrName(value.part)}`;
  if ('material' in value) return `material:${value.material === null ? 'none' : placeOrName(value.material)}`;
  if ('label' in value && typeof value.label?.attribute === 'string' && Object.keys(value.label).length === 2) {
    return typeof value.label.value === 'number' ? `label:${value.label.attribute}=${value.label.value}` : undefined;
  }
  if ('sphere' in value && isPlace(value.sphere?.center) && Object.keys(value.sphere).length === 2) {
    return `sphere:${[...value.sphere.center, value.sphere.radius].join(',')}`;
  }
  if ('box' in value && isPlace(value.box?.min) && isPlace(value.box.max) && Object.keys(value.box).length === 2) {
    return `box:${[...value.box.min, ...value.box.max].join(',')}`;
  }
  return undefined;
}

/** Names that would be taken for something else are in quotes. */
function placeOrName(value: number | string): string {
  if (typeof value !== 'string') return String(value);
  return /^([0-9]*|none|".*")$/s.test(value) ? `"${value}"` : value;
}

function isPlace(value: unknown): value is Xyz {
  return Array.isArray(value) && value.length === 3;
}
