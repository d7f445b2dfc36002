/**
 * The surface's shader: matte clay where there is no field; else the colour map, isolines
 * as lines of constant width in pixels, and regions with crisp borders. The field floods
 * the surface up to `reveal`. Everything is per fragment, so lines stay sharp however
 * near one comes.
 *
 * Attributes: `field` and `shade`, a number a vertex (drawn units; +Infinity where
 * unreached): isolines are those of `field`, colours those of `shade`. `regions0` and
 * `regions1`: a number for each of eight regions, of which the least wins. Of more regions,
 * `region`: which, and its slot; regions that touch are in different slots.
 */
import { Color, DataTexture, DoubleSide, GLSL3, ShaderMaterial, Vector3 } from 'three';
import { COLOUR_MAPS_GLSL, REGION_COLOURS, type ColourMap } from './colour_maps.ts';

const VERTEX = /* glsl */ `
  in float field;
  in float shade;
  #ifdef REGIONS
    #ifdef MANY
      in vec2 region;
      out vec4 vLabels0;
      out vec4 vLabels1;
    #else
      in vec4 regions0;
      in vec4 regions1;
    #endif
    out vec4 vRegions0;
    out vec4 vRegions1;
  #endif
  out vec3 vView;
  out vec3 vNormal;
  out float vField;
  out float vShade;
  void main() {
    vec4 view = modelViewMatrix * vec4(position, 1.0);
    vView = view.xyz;
    vNormal = normalMatrix * normal;
    // Infinity would make its neighbours NaN: far below 0 it is unreached all the same.
    vField = field < 1e30 ? field : -1e30;
    vShade = shade < 1e30 ? shade : 0.0;
    #ifdef MANY
      // Within a face the share of a slot, and of its region's number the same share.
      vec4 in0 = 1.0 - min(abs(vec4(0.0, 1.0, 2.0, 3.0) - region.y), 1.0);
      vec4 in1 = 1.0 - min(abs(vec4(4.0, 5.0, 6.0, 7.0) - region.y), 1.0);
      vRegions0 = 1.0 - in0;
      vRegions1 = 1.0 - in1;
      vLabels0 = in0 * region.x;
      vLabels1 = in1 * region.x;
    #elif defined(REGIONS)
      vRegions0 = regions0;
      vRegions1 = regions1;
    #endif
    gl_Position = projectionMatrix * view;
  }`;

const FRAGMENT = /* glsl */ `
  in vec3 vView;
  in vec3 vNormal;
  in float vField;
  in float vShade;
  #ifdef REGIONS
    in vec4 vRegions0;
    in vec4 vRegions1;
    uniform highp sampler2D regionColours;
  #endif
  #ifdef MANY
    in vec4 vLabels0;
    in vec4 vLabels1;
  #endif
  uniform vec3 clay;
  uniform float reveal;
  uniform float most;
  uniform float lineStep;
  uniform float edgeWidth;
  uniform float disc;
  out vec4 colour;

  ${COLOUR_MAPS_GLSL}

  /* The smooth normal, but the face's own where the two are far apart: creases stay creases. */
  vec3 normalSeen() {
    vec3 flatOne = normalize(cross(dFdx(vView), dFdy(vView)));
    vec3 smoothOne = normalize(vNormal);
    float along = dot(flatOne, smoothOne);
    smoothOne *= along < 0.0 ? -1.0 : 1.0;
    return normalize(mix(flatOne, smoothOne, smoothstep(0.72, 0.88, abs(along))));
  }

  /* How much of this pixel is covered by lines at the whole numbers of x, this wide in pixels. */
  float lines(float x, float width) {
    float perPixel = max(length(vec2(dFdx(x), dFdy(x))), 1e-9);
    float away = abs(x - floor(x + 0.5)) / perPixel;
    float cover = 1.0 - smoothstep(width * 0.5 - 0.5, width * 0.5 + 0.5, away);
    // Closer together than pixels they are but their mean.
    return cover * (1.0 - smoothstep(0.22, 0.5, perPixel));
  }

  void main() {
    vec3 n = normalSeen();
    vec3 eye = normalize(-vView);
    float key = max(dot(n, normalize(vec3(-0.35, 0.75, 0.75))), 0.0);
    float fill = 0.5 + 0.5 * dot(n, normalize(vec3(0.6, -0.1, 0.45)));
    float rim = pow(1.0 - max(dot(n, eye), 0.0), 3.0);
    float light = 0.34 + 0.50 * key + 0.26 * fill;

    vec3 base = clay * (light + 0.10 * rim);
    float away = reveal - vField;
    // All derivatives before any branch, as GLSL has them undefined inside.
    float front = max(fwidth(vField), 1e-9);
    float fieldLines = lineStep > 0.0 ? lines(vField / lineStep, 1.3) : 0.0;
    float fifthLines = lineStep > 0.0 ? lines(vField / (5.0 * lineStep), 2.2) : 0.0;

    float rimOfDisc = 1.0 - smoothstep(1.2, 2.2, abs(vField - disc) / max(length(vec2(dFdx(vField), dFdy(vField))), 1e-9));

    #ifdef REGIONS
      // Each number with its own slope: that of their difference jumps at the border.
      vec4 x0 = dFdx(vRegions0), y0 = dFdy(vRegions0), x1 = dFdx(vRegions1), y1 = dFdy(vRegions1);
      float best = vRegions0.x, second = 1e30;
      vec2 slope = vec2(x0.x, y0.x), slopeOfSecond = vec2(0.0);
      int won = 0;
      for (int i = 1; i < 8; i++) {
        float here = i < 4 ? vRegions0[i] : vRegions1[i - 4];
        vec2 slopeHere = i < 4 ? vec2(x0[i], y0[i]) : vec2(x1[i - 4], y1[i - 4]);
        if (here < best) {
          second = best; slopeOfSecond = slope;
          best = here; slope = slopeHere; won = i;
        } else if (here < second) { second = here; slopeOfSecond = slopeHere; }
      }
      #ifdef MANY
        float number = (won < 4 ? vLabels0[won] : vLabels1[won - 4]) / max(1.0 - best, 1e-6);
        int region = int(number + 0.5);
      #else
        int region = won;
      #endif
      vec3 hue = texelFetch(regionColours, ivec2(clamp(region, 0, textureSize(regionColours, 0).x - 1), 0), 0).rgb;
      float gap = second - best;
      float border = 1.0 - smoothstep(0.6, 1.6, gap / max(length(slopeOfSecond - slope), 1e-9));
      hue *= 0.78 + 0.22 * (1.0 - clamp(vField / most, 0.0, 1.0));
      hue = mix(hue, vec3(0.08), 0.85 * border);
    #else
      vec3 hue = MAP(vShade / most);
    #endif

    if (vField > -1e20 && away > -front) {
      // Matte: the light says the shape and leaves the colour readable against the legend.
      vec3 painted = hue * (0.66 + 0.30 * key + 0.16 * fill) + 0.03 * rim;
      float ink = max(0.55 * fieldLines, 0.8 * fifthLines);
      vec3 inkColour = dot(hue, vec3(0.3, 0.59, 0.11)) > 0.34 ? hue * 0.22 : mix(hue, vec3(1.0), 0.62);
      painted = mix(painted, inkColour, ink);
      // Beyond the disc the surface is half clay, and its outline is bright.
      if (disc > 0.0) painted = mix(mix(painted, clay * light, vField > disc ? 0.6 : 0.0), vec3(1.0), rimOfDisc);
      // The front glows while it runs.
      float glow = reveal < 1e29 ? exp(-abs(away) / max(edgeWidth, 1e-9)) : 0.0;
      painted = mix(painted, vec3(1.0), 0.55 * glow);
      base = mix(base, painted, smoothstep(-front, front, away));
    }
    colour = vec4(base, 1.0);
  }`;

/** `regions` by the distance from each of eight sources; `many` by the number of the nearest. */
export type Painting = ColourMap | 'regions' | 'many';

/** Clay by itself; `paint` says what a field is painted with. */
export class FieldMaterial extends ShaderMaterial {
  #colours: readonly string[] = REGION_COLOURS;

  constructor() {
    super({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      side: DoubleSide,
      defines: { MAP: 'viridis' },
      uniforms: {
        clay: { value: new Vector3(0.8, 0.77, 0.73) },
        reveal: { value: -1 },
        most: { value: 1 },
        lineStep: { value: 0 },
        edgeWidth: { value: 1 },
        disc: { value: 0 },
        regionColours: { value: coloursOf(REGION_COLOURS) },
      },
      // Lines and markers lie on the surface: it makes room for half their width.
      polygonOffset: true,
      polygonOffsetFactor: 1.5,
      polygonOffsetUnits: 4,
    });
  }

  /** An sRGB colour such as `#c8beb4`; lighting is done in it as it is. */
  setClay(text: string): void {
    this.uniforms['clay']!.value.copy(rgbOf(text));
  }

  /** `most`: the value of the map's upper end; `lineStep`: between isolines, 0 for none. Drawn units. */
  paint(painting: Painting, most: number, lineStep: number): void {
    const before = JSON.stringify(this.defines);
    const byRegion = painting === 'regions' || painting === 'many';
    this.defines = {
      MAP: byRegion ? this.defines['MAP'] : painting,
      ...(byRegion && { REGIONS: '' }),
      ...(painting === 'many' && { MANY: '' }),
    };
    if (before !== JSON.stringify(this.defines)) this.needsUpdate = true;
    this.uniforms['most']!.value = Math.max(most, 1e-30);
    this.uniforms['lineStep']!.value = lineStep;
  }

  /** A colour for each region, such as `#e8835a`. */
  setRegions(colours: readonly string[]): void {
    if (colours === this.#colours) return;
    this.#colours = colours;
    this.uniforms['regionColours']!.value.dispose();
    this.uniforms['regionColours']!.value = coloursOf(colours);
  }

  /** The radius of the disc that is set off, in drawn units; 0 for none. */
  setDisc(radius: number): void {
    this.uniforms['disc']!.value = radius;
  }

  /** Up to which distance the field is shown; Infinity for all, -1 for clay only. */
  reveal(distance: number, edgeWidth = 1): void {
    this.uniforms['reveal']!.value = Math.min(distance, 1e30);
    this.uniforms['edgeWidth']!.value = edgeWidth;
  }
}

/** Colours side by side as texels; lighting is done in them as they are. */
function coloursOf(texts: readonly string[]): DataTexture {
  const bytes = texts.flatMap((text) => [...[1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)), 255]);
  const texture = new DataTexture(new Uint8Array(bytes), texts.length, 1);
  texture.needsUpdate = true;
  return texture;
}

function rgbOf(text: string): Vector3 {
  const { r, g, b } = new Color().setStyle(text, '');
  return new Vector3(r, g, b);
}
