/** Painted faces, hatched: those that are forbidden, or all that are not painted; between the lines of weighted ones the surface is seen. */
import { BufferAttribute, BufferGeometry, DoubleSide, GLSL3, Mesh, ShaderMaterial, Vector3 } from 'three';
import { maskOf } from './painted.ts';
import type { Stage } from './stage.ts';
import type { Painted } from './state.ts';
import type { Surface } from './surface.ts';

const VERTEX = /* glsl */ `
  out vec3 view;
  void main() {
    vec4 at = modelViewMatrix * vec4(position, 1.0);
    view = at.xyz;
    gl_Position = projectionMatrix * at;
  }`;

const FRAGMENT = /* glsl */ `
  uniform float pixels;
  uniform vec3 hue;
  uniform bool seenThrough;
  in vec3 view;
  out vec4 colour;
  void main() {
    vec3 n = normalize(cross(dFdx(view), dFdy(view)));
    float light = 0.82 + 0.18 * abs(dot(n, normalize(vec3(-0.35, 0.75, 0.75))));
    float away = abs(fract((gl_FragCoord.x + gl_FragCoord.y) / (9.0 * pixels)) - 0.5) * 9.0;
    float line = smoothstep(1.8, 2.6, away);
    if (seenThrough && line < 0.5) discard;
    vec3 hatch = hue * mix(1.0, 0.55, line);
    colour = vec4(hatch * light, 1.0);
  }`;

/** Red where one may not go; grey where nothing is asked about; dark lines where paths have a weight. */
const FORBIDDEN = [0.58, 0.18, 0.2];
const OUTSIDE = [0.47, 0.49, 0.53];
const WEIGHTED = [0.25, 0.2, 0.12];

export class PaintedView {
  readonly #geometry = new BufferGeometry();
  readonly #material = new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: DoubleSide,
    uniforms: { pixels: { value: 1 }, hue: { value: new Vector3() }, seenThrough: { value: false } },
    // In front of the surface, which is moved back farther, and behind the lines.
    polygonOffset: true,
    polygonOffsetFactor: 0.7,
    polygonOffsetUnits: 2,
  });
  readonly #mesh = new Mesh(this.#geometry, this.#material);
  #wanted: { surface: Surface; mask: Uint8Array; as: Painted['as'] } | null = null;

  constructor(private readonly stage: Stage) {
    this.#mesh.frustumCulled = false;
    stage.beforeFrame(() => this.#build());
  }

  show(surface: Surface | null, painted: Painted): void {
    if (surface && painted.faces.length) return this.preview(surface, maskOf(painted, surface.about.faces), painted.as);
    this.#wanted = null;
    this.stage.remove(this.#mesh);
  }

  /** While a stroke goes on: `mask` has a byte a face, 1 where it is painted. */
  preview(surface: Surface, mask: Uint8Array, as: Painted['as']): void {
    this.#wanted = { surface, mask, as };
    this.stage.wake();
  }

  /** Once a frame, however many dabs there were. */
  #build(): void {
    if (!this.#wanted) return;
    const { surface, mask, as } = this.#wanted;
    this.#wanted = null;
    let painted = 0;
    for (const value of mask) painted += value;
    const hatched = as === 'within' ? 0 : 1;
    const count = hatched ? painted : painted && mask.length - painted;
    const corners = new Uint32Array(3 * count);
    let next = 0;
    for (let face = 0; next < corners.length; face++) {
      if (mask[face] !== hatched) continue;
      corners.set(surface.triangles.subarray(3 * face, 3 * face + 3), next);
      next += 3;
    }
    this.#geometry.dispose();
    this.#geometry.setAttribute('position', surface.geometry.getAttribute('position'));
    this.#geometry.setIndex(new BufferAttribute(corners, 1));
    this.#material.uniforms['pixels']!.value = Math.min(devicePixelRatio, 2);
    this.#material.uniforms['hue']!.value.fromArray({ forbid: FORBIDDEN, within: OUTSIDE, weights: WEIGHTED }[as]);
    this.#material.uniforms['seenThrough']!.value = as === 'weights';
    if (count) this.stage.scene.add(this.#mesh);
    else this.stage.scene.remove(this.#mesh);
  }
}
