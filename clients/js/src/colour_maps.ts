/**
 * Colour maps, once as numbers and once as the same numbers in GLSL. viridis and magma are
 * polynomial fits of the tables by Smith and van der Walt, turbo is the fit by Mikhailov;
 * all give sRGB.
 */

export type ColourMap = 'viridis' | 'turbo' | 'magma';
/** Red, green, blue; sRGB, bytes. */
export type Rgb = readonly [number, number, number];

/** Coefficients from the constant on, each red, green, blue. */
const COEFFICIENTS: Record<ColourMap, readonly Rgb[]> = {
  viridis: [
    [0.277727, 0.005407, 0.3341],
    [0.105093, 1.404614, 1.38459],
    [-0.330862, 0.214848, 0.095095],
    [-4.63423, -5.799101, -19.332441],
    [6.22827, 14.179933, 56.690553],
    [4.776385, -13.745145, -65.353033],
    [-5.435456, 4.645853, 26.312435],
  ],
  turbo: [
    [0.135721, 0.091403, 0.106673],
    [4.615393, 2.194188, 12.641946],
    [-42.660323, 4.842967, -60.582048],
    [132.131082, -14.185033, 110.362768],
    [-152.942394, 4.277299, -89.903109],
    [59.286379, 2.829566, 27.34825],
  ],
  magma: [
    [-0.002136, -0.00075, -0.005386],
    [0.251661, 0.677523, 2.494027],
    [8.353717, -3.57772, 0.314468],
    [-27.668733, 14.264731, -13.649213],
    [52.17614, -27.943606, 12.944169],
    [-50.768525, 29.046583, 4.234153],
    [18.655706, -11.489774, -5.601961],
  ],
};

/** The map's colour at `t` in [0, 1], as bytes. */
export function colourAt(map: ColourMap, t: number): Rgb {
  const x = Math.min(1, Math.max(0, t));
  const sum: [number, number, number] = [0, 0, 0];
  const rows = COEFFICIENTS[map];
  for (let row = rows.length - 1; row >= 0; row--) {
    for (let c = 0; c < 3; c++) sum[c] = sum[c]! * x + rows[row]![c]!;
  }
  return sum.map((part) => Math.round(255 * Math.min(1, Math.max(0, part)))) as unknown as Rgb;
}

/** `vec3 NAME(float t)` for each map. */
export const COLOUR_MAPS_GLSL = Object.entries(COEFFICIENTS)
  .map(([name, rows]) => {
    const vectors = rows.map((row) => `vec3(${row.map((part) => part.toFixed(6)).join(', ')})`);
    const horner = vectors.reduceRight((inner, vector) => (inner ? `${vector} + t * (${inner})` : vector), '');
    return `vec3 ${name}(float t) { t = clamp(t, 0.0, 1.0); return clamp(${horner}, 0.0, 1.0); }`;
  })
  .join('\n');
