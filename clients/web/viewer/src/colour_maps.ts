/** The colours of the page: the client's colour maps, and those of regions. */
import { colourOf } from './oklab.ts';

export { COLOUR_MAPS_GLSL, colourAt, type ColourMap } from 'geodesicd-client';

/** Colours of the first regions: apart in hue and in lightness, for eyes of any kind. */
export const REGION_COLOURS: readonly string[] = [
  '#e8835a', '#4f8fd0', '#e3c04f', '#5aa87c', '#b071c4', '#8a9aa8', '#d46a92', '#6cc4c9',
];

/** Degrees: hues at multiples of it never come close to each other soon. */
const GOLDEN = 137.50776;
/** In turn, so that hues that do come close differ in lightness; less chroma where screens have less. */
const LIGHTNESS = [[0.76, 0.12], [0.56, 0.13], [0.67, 0.06], [0.85, 0.1], [0.64, 0.14]] as const;

/** How many there are. */
export const LIGHTNESSES = LIGHTNESS.length;

/** The colour of a region by its place among the sources, from 0 and without an end. */
export function regionColour(index: number): string {
  const first = REGION_COLOURS[index];
  if (first) return first;
  const [lightness, chroma] = LIGHTNESS[index % LIGHTNESS.length]!;
  return colourOf(lightness, chroma, (index * GOLDEN) % 360);
}
