/**
 * The mesh on the stage, painted with what the results say: distances, regions of the
 * nearest source, or the error against the exact method. A new field floods the surface.
 */
import { BufferAttribute, Mesh, MeshBasicMaterial, type BufferGeometry } from 'three';
import { UNREACHED } from 'geodesicd-client';
import { setField } from 'geodesicd-client/three';
import { FieldMaterial } from './field_material.ts';
import { roundStep } from './numbers.ts';
import type { KnownField, Results } from './results.ts';
import { wantsMotion, type Stage } from './stage.ts';
import type { RegionLook } from './regions.ts';
import { byCost, byRegion as showsRegions, differ, type State } from './state.ts';

const FLOOD = 650; // milliseconds from the source to the farthest vertex

/**
 * Distances for the shader, in drawn units: those of a mesh in any unit, be it 1e30 or 1e-30,
 * are near 1 then, where float32 and the shader's own bounds have room.
 */
function drawn(values: Float32Array, radius: number): Float32Array {
  return values.map((value) => value / radius);
}

/** Between isolines of about this many up to `max`, round; 0 for none. */
export function lineStepOf(max: number, lines: number): number {
  return lines > 0 && max > 0 ? roundStep(max / lines) : 0;
}

export class SurfaceView {
  readonly #material = new FieldMaterial();
  readonly #mesh = new Mesh<BufferGeometry, FieldMaterial>(undefined, this.#material);
  /** The same triangles as lines, drawn over the surface. */
  readonly #edges = new Mesh<BufferGeometry, MeshBasicMaterial>(
    undefined,
    new MeshBasicMaterial({ wireframe: true, color: '#10131a', transparent: true, opacity: 0.34, depthWrite: false }),
  );
  #shown: KnownField | null = null;
  /** Mesh units of one drawn unit, of the surface that is shown. */
  #radius = 1;
  #floodFrom: number | null = null;
  /** Set while a source is dragged: the field then just is there. */
  still = false;

  constructor(private readonly stage: Stage) {
    stage.beforeFrame((now) => this.#flood(now));
    stage.warm(this.#material);
  }

  setClay(colour: string): void {
    this.#material.setClay(colour);
    this.stage.wake();
  }

  follow(state: State, before: State, results: Results, resultsBefore: Results): void {
    const { surface, field, error, regions } = results;
    const apart = field && results.apart?.key === field.key ? results.apart.fields : null;
    if (surface && surface !== resultsBefore.surface) {
      this.stage.remove(this.#mesh);
      this.#mesh.geometry = surface.geometry;
      this.#radius = surface.radius;
      this.stage.add(this.#mesh);
      this.#shown = null;
    }
    if (!surface) return void this.stage.remove(this.#mesh, this.#edges);
    if (surface !== resultsBefore.surface || state.edges !== before.edges) {
      this.stage.remove(this.#edges);
      this.#edges.geometry = surface.geometry;
      if (state.edges) this.stage.add(this.#edges);
    }
    this.#material.setDisc(byCost(state) ? 0 : (state.disc ?? 0) / surface.radius);
    if (differ(state, before, 'disc', 'walking', 'painted')) this.stage.wake();
    const repaint = field !== this.#shown || differ(results, resultsBefore, 'error', 'apart', 'regions') || differ(state, before, 'show', 'colours', 'lines');
    if (!repaint) return;
    if (!field) {
      this.#shown = null;
      this.#material.reveal(-1);
      return this.stage.wake();
    }
    const { geometry, radius } = surface;
    if (field !== this.#shown) {
      setField(geometry, drawn(field.values, radius));
      this.#startFlood(this.#shown === null || !this.still);
    }
    this.#shown = field;
    const most = field.max / radius;
    const step = lineStepOf(field.max, state.lines) / radius;
    const byRegion = showsRegions(state.show) && field.labels && regions;
    const byError = state.show === 'error' && error;
    if (byRegion && apart) putDistances(geometry, apart, radius);
    else if (byRegion) putLabels(geometry, field.labels!, regions);
    // One buffer for both where they are the same; never the field's for the error.
    if (byError) {
      if (geometry.getAttribute('shade') === geometry.getAttribute('field')) geometry.deleteAttribute('shade');
      setField(geometry, error.values, 'shade');
    } else geometry.setAttribute('shade', geometry.getAttribute('field'));
    if (byRegion) {
      this.#material.paint(apart ? 'regions' : 'many', most, step);
      this.#material.setRegions(regions.colours);
    }
    else if (byError) this.#material.paint('magma', Math.max(error.most, 1e-12), step);
    else this.#material.paint(state.colours, most, step);
    this.stage.wake();
  }

  #startFlood(animate: boolean): void {
    if (!animate || !wantsMotion()) {
      this.#floodFrom = null;
      this.#material.reveal(Infinity);
    } else this.#floodFrom = performance.now();
  }

  #flood(now: number): boolean {
    if (this.#floodFrom === null || !this.#shown) return false;
    const part = Math.max(0, now - this.#floodFrom) / FLOOD;
    if (part >= 1) {
      this.#floodFrom = null;
      this.#material.reveal(Infinity);
      return false;
    }
    const eased = 1 - (1 - part) ** 2.2;
    const max = this.#shown.max / this.#radius;
    this.#material.reveal(eased * 1.06 * max, 0.03 * max);
    return true;
  }
}

/**
 * Eight numbers a vertex, of which the least says the region: the distances from each of
 * the sources. The shader finds the border inside faces.
 */
function putDistances(geometry: BufferGeometry, apart: readonly KnownField[], radius: number): void {
  for (const half of [0, 1]) {
    const weights = new Float32Array(4 * apart[0]!.values.length).fill(1e30);
    apart.slice(4 * half, 4 * half + 4).forEach(({ values }, k) => {
      values.forEach((value, vertex) => { weights[4 * vertex + k] = Math.min(value / radius, 1e30); });
    });
    geometry.setAttribute(`regions${half}`, new BufferAttribute(weights, 4));
  }
}

/** A region and its slot a vertex; -1 for the slot where no source reaches. */
function putLabels(geometry: BufferGeometry, labels: Uint32Array, { slots }: RegionLook): void {
  const pairs = new Float32Array(2 * labels.length);
  labels.forEach((label, vertex) => {
    pairs[2 * vertex] = label === UNREACHED ? 0 : label;
    pairs[2 * vertex + 1] = slots[label] ?? -1;
  });
  geometry.setAttribute('region', new BufferAttribute(pairs, 2));
}
