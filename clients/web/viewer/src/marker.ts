/**
 * A point on the surface as a small ball of constant size on the screen, with a halo: a
 * square that faces the eye and whose shader draws the ball. Sources are full, targets
 * have a white heart, so that the two differ without their colours. Faint where hidden.
 */
import { Color, GLSL3, Group, Mesh, PlaneGeometry, ShaderMaterial, Vector2, Vector3 } from 'three';

export type MarkerKind = 'source' | 'target' | 'via' | 'arrow' | 'loop' | 'end';

const LOOK: Record<MarkerKind, { colour: string; pixels: number; heart: number }> = {
  source: { colour: '#ff5d3b', pixels: 19, heart: 0 },
  target: { colour: '#2f7dff', pixels: 19, heart: 0.45 },
  via: { colour: '#f4b740', pixels: 15, heart: 0 },
  arrow: { colour: '#b455ff', pixels: 17, heart: 0 },
  loop: { colour: '#12b8a6', pixels: 15, heart: 0.3 },
  end: { colour: '#b455ff', pixels: 12, heart: 0.4 },
};

/** Pixels from the middle within which a pointer holds a marker. */
export const REACH = { mouse: 15, touch: 26 };

const VERTEX = /* glsl */ `
  uniform vec2 size; // of the square, in parts of the view
  uniform float lift;
  out vec2 at;
  void main() {
    at = position.xy * 2.0;
    vec4 view = modelViewMatrix * vec4(0.0, 0.0, 0.0, 1.0);
    view.xyz *= lift;
    gl_Position = projectionMatrix * view;
    gl_Position.xy += position.xy * size * gl_Position.w;
  }`;

const FRAGMENT = /* glsl */ `
  uniform vec3 hue;
  uniform float heart;
  uniform float opacity;
  uniform float held;
  in vec2 at;
  out vec4 colour;
  void main() {
    // The ball's edge is at half of the square; the rest is halo.
    float r = length(at) * 2.0;
    float soft = fwidth(r);
    float ball = 1.0 - smoothstep(1.0 - soft, 1.0 + soft, r);
    float rim = 1.0 - smoothstep(1.24 - soft, 1.24 + soft, r);
    float inner = 1.0 - smoothstep(heart - soft, heart + soft, r);
    vec3 n = vec3(at * 2.0, sqrt(max(0.0, 1.0 - r * r)));
    float light = 0.72 + 0.34 * max(dot(n, normalize(vec3(-0.4, 0.7, 0.6))), 0.0);
    vec3 inside = mix(hue * light, vec3(1.0), heart > 0.0 ? inner : 0.0);
    vec3 c = mix(vec3(1.0), inside, ball);
    float halo = (0.30 + 0.35 * held) * (1.0 - smoothstep(1.0, 2.0, r));
    float a = max(rim, halo);
    c = mix(hue, c, rim);
    colour = vec4(c, a * opacity);
    if (colour.a < 0.01) discard;
  }`;

const square = new PlaneGeometry(1, 1);

export class Marker extends Group {
  readonly #materials: ShaderMaterial[];
  readonly #pixels: number;

  constructor(
    readonly kind: MarkerKind,
    /** Instead of the kind's own. */
    readonly colour?: string,
  ) {
    super();
    const { pixels, heart, colour: own } = LOOK[kind];
    this.#pixels = 2 * pixels;
    const { r, g, b } = new Color().setStyle(colour ?? own, '');
    const pass = (hidden: boolean) => {
      const material = new ShaderMaterial({
        glslVersion: GLSL3,
        vertexShader: VERTEX,
        fragmentShader: FRAGMENT,
        transparent: true,
        depthWrite: false,
        depthTest: !hidden,
        uniforms: {
          size: { value: new Vector2() },
          lift: { value: 0.985 },
          hue: { value: new Vector3(r, g, b) },
          heart: { value: heart },
          opacity: { value: hidden ? 0.28 : 1 },
          held: { value: 0 },
        },
      });
      const mesh = new Mesh(square, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = hidden ? 40 : 41;
      this.add(mesh);
      return material;
    };
    this.#materials = [pass(true), pass(false)];
  }

  /** To be called when the view's size changes: width and height in CSS pixels. */
  fit(width: number, height: number): void {
    for (const { uniforms } of this.#materials) {
      uniforms['size']!.value.set((2 * this.#pixels) / width, (2 * this.#pixels) / height);
    }
  }

  set held(held: boolean) {
    for (const { uniforms } of this.#materials) uniforms['held']!.value = held ? 1 : 0;
  }

  override dispose(): void {
    super.dispose();
    for (const material of this.#materials) material.dispose();
  }
}
