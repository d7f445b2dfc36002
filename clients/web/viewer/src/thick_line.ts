/**
 * A polyline on the surface, some pixels wide: a bright core in a dark casing, so that it
 * is seen on every colour, and a faint trace of it where the surface hides it. Its points
 * change sixty times a second while a target is dragged, so the buffer on the GPU is kept
 * and only grows.
 */
import {
  DynamicDrawUsage,
  GreaterDepth,
  Group,
  InstancedInterleavedBuffer,
  InterleavedBufferAttribute,
  NotEqualStencilFunc,
  ReplaceStencilOp,
} from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';

/** Towards the eye by this part of the distance: above the surface, without a shift on the screen. */
export const LIFT = 0.004;

export interface LineLook {
  readonly core: string;
  readonly casing: string;
  /** Of the core, in CSS pixels. */
  readonly width: number;
  /** Which of two lines covers the other. */
  readonly order: number;
}

function material(colour: string, width: number, hidden: boolean): LineMaterial {
  // No depth is written: the casing of one segment would cover the core of the next.
  // Among what is transparent, as the mesh's edges are, the order counts; what is opaque would be below them.
  const made = new LineMaterial({ color: colour, linewidth: width, depthWrite: false, transparent: true });
  if (hidden) {
    // Round joints overlap: the stencil lets each pixel be mixed once.
    Object.assign(made, {
      opacity: 0.3,
      depthFunc: GreaterDepth,
      stencilWrite: true,
      stencilRef: 1,
      stencilFunc: NotEqualStencilFunc,
      stencilZPass: ReplaceStencilOp,
    });
  }
  made.onBeforeCompile = (shader) => {
    for (const end of ['Start', 'End']) {
      const line = `vec4 ${end.toLowerCase()} = modelViewMatrix * vec4( instance${end}, 1.0 );`;
      if (!shader.vertexShader.includes(line)) throw new Error(`the line shader has no longer: ${line}`);
      shader.vertexShader = shader.vertexShader.replace(
        line,
        `${line} ${end.toLowerCase()}.xyz *= ${(1 - LIFT).toFixed(4)};`,
      );
    }
  };
  return made;
}

export class ThickLine extends Group {
  #geometry = new LineSegmentsGeometry();
  readonly #core: string;
  #room = 0;
  #buffer: InstancedInterleavedBuffer | null = null;
  readonly #passes: LineSegments2[];

  constructor({ core, casing, width, order }: LineLook) {
    super();
    this.#core = core;
    const pass = (made: LineMaterial, after: number) => {
      const line = new LineSegments2(this.#geometry, made);
      line.frustumCulled = false;
      line.renderOrder = order + after;
      this.add(line);
      return line;
    };
    this.#passes = [
      pass(material(casing, width + 3, false), 0),
      pass(material(core, width, false), 0.1),
      pass(material(core, width, true), 0.2),
    ];
    this.visible = false;
  }

  /** What is not the answer any more is grey and has no casing. */
  set faded(faded: boolean) {
    this.#passes[0]!.visible = !faded;
    for (const pass of this.#passes.slice(1)) pass.material.color.set(faded ? '#a7aebb' : this.#core);
  }

  /** Points x, y, z after x, y, z, where they are drawn; fewer than two show nothing. */
  setPoints(points: Float32Array): void {
    this.setLines([points]);
  }

  /** The same of several lines. */
  setLines(lines: readonly Float32Array[]): void {
    const segments = lines.reduce((sum, { length }) => sum + Math.max(0, length / 3 - 1), 0);
    this.visible = segments > 0;
    if (segments <= 0) return;
    if (segments > this.#room || !this.#buffer) this.#grow(Math.max(256, 2 * segments));
    const array = this.#buffer!.array as Float32Array;
    let next = 0;
    for (const points of lines) {
      for (let i = 0; i + 6 <= points.length; i += 3, next += 6) array.set(points.subarray(i, i + 6), next);
    }
    this.#buffer!.clearUpdateRanges();
    this.#buffer!.addUpdateRange(0, 6 * segments);
    this.#buffer!.needsUpdate = true;
    this.#geometry.instanceCount = segments;
  }

  #grow(room: number): void {
    this.#geometry.dispose();
    this.#geometry = new LineSegmentsGeometry();
    this.#buffer = new InstancedInterleavedBuffer(new Float32Array(6 * room), 6, 1);
    this.#buffer.setUsage(DynamicDrawUsage);
    this.#geometry.setAttribute('instanceStart', new InterleavedBufferAttribute(this.#buffer, 3, 0));
    this.#geometry.setAttribute('instanceEnd', new InterleavedBufferAttribute(this.#buffer, 3, 3));
    this.#room = room;
    for (const line of this.#passes) line.geometry = this.#geometry;
  }

  override dispose(): void {
    super.dispose();
    this.#geometry.dispose();
    for (const line of this.#passes) line.material.dispose();
  }
}
