/**
 * The brush: a stroke paints the faces round the places that it passes, or takes their paint away. Only
 * faces that hang together with the one under the pointer, so a thin part keeps its other side. The
 * state, and with it the server, is told when a stroke ends.
 */
import { Vector3 } from 'three';
import { maskOf, rangesOf } from './painted.ts';
import type { PaintedView } from './painted_view.ts';
import type { Picking } from './picking.ts';
import type { Stage } from './stage.ts';
import type { Spot, State, Store } from './state.ts';
import type { Surface } from './surface.ts';

/** At most so many dabs between two movements of a pointer. */
const DABS = 24;

interface Stroke {
  readonly surface: Surface;
  readonly mask: Uint8Array;
  readonly value: 0 | 1;
  x: number;
  y: number;
}

export class Painter {
  #stroke: Stroke | null = null;
  #round: { surface: Surface; faces: FacesRound } | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly picking: Picking,
    private readonly state: Store<State>,
    private readonly surface: () => Surface | null,
    private readonly view: PaintedView,
  ) {}

  /** Begins a stroke at a place on the page; whether the surface is there. */
  begin(x: number, y: number, erase: boolean): boolean {
    const spot = this.#spotAt(x, y);
    if (!spot) return false;
    this.#start(x, y, erase);
    this.#dab(spot);
    return true;
  }

  move(x: number, y: number): void {
    const stroke = this.#stroke;
    if (!stroke) return;
    const way = Math.hypot(x - stroke.x, y - stroke.y);
    const steps = Math.min(DABS, Math.max(1, Math.ceil(way / Math.max(3, 0.5 * (this.pixelsAt(x, y) ?? 12)))));
    for (let step = 1; step <= steps; step++) {
      const spot = this.#spotAt(stroke.x + ((x - stroke.x) * step) / steps, stroke.y + ((y - stroke.y) * step) / steps);
      if (spot) this.#dab(spot);
    }
    [stroke.x, stroke.y] = [x, y];
  }

  end(): void {
    const stroke = this.#stroke;
    this.#stroke = null;
    if (!stroke || this.surface() !== stroke.surface) return;
    const { painted } = this.state.value;
    const faces = rangesOf(stroke.mask);
    const same = faces.length === painted.faces.length && faces.every(([first, last], at) => first === painted.faces[at]![0] && last === painted.faces[at]![1]);
    if (!same) this.state.set({ painted: { ...painted, faces } });
  }

  /** As if the stroke had not been. */
  takeBack(): void {
    if (!this.#stroke) return;
    this.#stroke = null;
    this.view.show(this.surface(), this.state.value.painted);
  }

  /** One dab at a place of the surface. */
  dab(spot: Spot): void {
    this.#start(0, 0, this.state.value.erasing);
    this.#dab(spot);
    this.end();
  }

  /** How many CSS pixels the brush's radius is at a place on the page; null beside the mesh. */
  pixelsAt(x: number, y: number): number | null {
    const place = this.picking.at(x, y, this.stage.camera)?.place;
    if (!place) return null;
    const aside = new Vector3().setFromMatrixColumn(this.stage.camera.matrixWorld, 0).setLength(this.state.value.brush).add(place);
    const [at, to] = [this.stage.onPage(place), this.stage.onPage(aside)];
    return at && to && Math.hypot(to.x - at.x, to.y - at.y);
  }

  #start(x: number, y: number, erase: boolean): void {
    const surface = this.surface();
    if (!surface) return;
    if (this.#round?.surface !== surface) this.#round = { surface, faces: new FacesRound(surface) };
    this.#stroke = { surface, mask: maskOf(this.state.value.painted, surface.about.faces), value: erase ? 0 : 1, x, y };
  }

  #spotAt(x: number, y: number): Spot | null {
    return this.surface() ? (this.picking.at(x, y, this.stage.camera)?.spot ?? null) : null;
  }

  #dab(spot: Spot): void {
    if (!this.#stroke || !this.#round) return;
    const { surface, mask, value } = this.#stroke;
    this.#round.faces.within(spot, this.state.value.brush, (face) => { mask[face] = value; });
    this.view.preview(surface, mask, this.state.value.painted.as);
  }
}

/** Which faces are round a place, by the corners that faces have in common. */
class FacesRound {
  /** The faces of each vertex, one vertex after the other. */
  readonly #faces: Uint32Array;
  readonly #begins: Uint32Array;
  /** In which search each face was met last. */
  readonly #met: Uint32Array;
  #search = 0;

  constructor(private readonly surface: Surface) {
    const { triangles, about } = surface;
    this.#begins = new Uint32Array(about.vertices + 1);
    for (const vertex of triangles) this.#begins[vertex + 1]!++;
    for (let vertex = 0; vertex < about.vertices; vertex++) this.#begins[vertex + 1]! += this.#begins[vertex]!;
    const next = this.#begins.slice();
    this.#faces = new Uint32Array(triangles.length);
    triangles.forEach((vertex, corner) => { this.#faces[next[vertex]!++] = Math.floor(corner / 3); });
    this.#met = new Uint32Array(triangles.length / 3);
  }

  /** The face of a spot, and those whose centroids are no farther (drawn units) and that such faces lead to. */
  within(spot: Spot, radius: number, found: (face: number) => void): void {
    const { triangles } = this.surface;
    const drawn = this.surface.geometry.getAttribute('position').array;
    const { x, y, z } = this.surface.placeOf(spot);
    const near = (face: number) => {
      const centre = [0, 0, 0];
      for (let corner = 0; corner < 3; corner++) {
        for (let axis = 0; axis < 3; axis++) centre[axis]! += drawn[3 * triangles[3 * face + corner]! + axis]! / 3;
      }
      return Math.hypot(centre[0]! - x, centre[1]! - y, centre[2]! - z) <= radius;
    };
    this.#search++;
    const waiting = [spot.face];
    this.#met[spot.face] = this.#search;
    for (let face = waiting.pop(); face !== undefined; face = waiting.pop()) {
      found(face);
      for (let corner = 0; corner < 3; corner++) {
        const vertex = triangles[3 * face + corner]!;
        for (let at = this.#begins[vertex]!; at < this.#begins[vertex + 1]!; at++) {
          const other = this.#faces[at]!;
          if (this.#met[other] === this.#search) continue;
          this.#met[other] = this.#search;
          if (near(other)) waiting.push(other);
        }
      }
    }
  }
}
