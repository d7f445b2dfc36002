/**
 * What lies on the surface: markers of the points, the path, the arrow with its straightest
 * geodesic, the kept measures, and distances along them as labels on the page.
 */
import { Vector3 } from 'three';
import type { Path } from 'geodesicd-client';
import { Labels, type Label } from './labels.ts';
import { Marker, REACH, type MarkerKind } from './marker.ts';
import { letterOf } from './measures.ts';
import { lengthText, roundStep, tickText } from './numbers.ts';
import type { Picking } from './picking.ts';
import { hueOf } from './regions.ts';
import { surfaceOf, type Results } from './results.ts';
import { drawnKey } from './shapes.ts';
import type { Stage } from './stage.ts';
import { byRegion, differ, type Line, type Spot, type State } from './state.ts';
import type { Surface } from './surface.ts';
import { ThickLine } from './thick_line.ts';

/** A marker that a pointer can hold, and what of the state it stands for. */
export interface Handle {
  readonly kind: 'source' | 'target' | 'via' | 'arrow' | 'loop' | 'tip';
  readonly index: number;
}

type AddMarker = (kind: MarkerKind, place: Vector3, handle: Handle | null, colour?: string) => void;

/** Drawn units from an arrow's start to its handle, in parts of the distance to the eye. */
export const ARROW = 0.085;

const DARK = '#10131a';

export class Overlay {
  readonly #path = new ThickLine({ core: '#ffffff', casing: DARK, width: 3.6, order: 20 });
  readonly #trace = new ThickLine({ core: '#c77dff', casing: '#2b0a4d', width: 3.2, order: 16 });
  readonly #shaft = new ThickLine({ core: '#b455ff', casing: '#ffffff', width: 4, order: 24 });
  readonly #drawn = new ThickLine({ core: '#6ff7e2', casing: '#06302c', width: 3.2, order: 18 });
  readonly #walls = new ThickLine({ core: '#d8404a', casing: '#2c0508', width: 4, order: 14 });
  readonly #curves = new ThickLine({ core: '#ff5d3b', casing: '#ffffff', width: 3.6, order: 13 });
  readonly #borders = new ThickLine({ core: '#ffffff', casing: DARK, width: 1.4, order: 8 });
  readonly #kept: ThickLine[] = [];
  readonly #walker = new Marker('end', '#1f2a37');
  #line: Float32Array = new Float32Array();
  readonly #labels: Labels;
  #markers: { handle: Handle | null; marker: Marker }[] = [];
  #state: State | null = null;
  #surface: Surface | null = null;

  constructor(
    private readonly stage: Stage,
    picking: Picking,
  ) {
    this.#labels = new Labels(stage, picking);
    stage.add(this.#path, this.#trace, this.#shaft, this.#drawn, this.#borders, this.#walls, this.#curves);
    stage.beforeFrame(() => this.#aim());
    stage.onResize((width, height) => this.#markers.forEach(({ marker }) => marker.fit(width, height)));
  }

  follow(state: State, before: State, results: Results, resultsBefore: Results): void {
    this.#state = state;
    this.#surface = surfaceOf(state, results);
    const other = results.surface !== resultsBefore.surface;
    const moved = other || differ(state, before, 'mesh', 'sources', 'via', 'target', 'arrow', 'loop', 'show') || differ(results, resultsBefore, 'trace', 'regions');
    if (moved) this.#placeMarkers(state, results);
    const relabel = state.ticks !== before.ticks || differ(results, resultsBefore, 'path', 'measured', 'drawn', 'cells');
    const surface = results.surface;
    if (other || results.path !== resultsBefore.path) this.#path.setPoints(pointsOf(surface, results.path));
    if (results.stale !== resultsBefore.stale) {
      this.#path.faded = results.stale;
      this.#labels.stale = results.stale;
    }
    if (other || differ(results, resultsBefore, 'path', 'along')) this.#walk(results);
    if (other || results.trace !== resultsBefore.trace) this.#trace.setPoints(pointsOf(surface, results.trace));
    if (other || results.drawn !== resultsBefore.drawn) this.#drawn.setPoints(pointsOf(surface, results.drawn));
    this.#drawn.faded = results.drawn !== null && results.drawn.key !== drawnKey(state);
    if (other || results.lines !== resultsBefore.lines) this.#placeLines(state, results);
    if (other || results.cells !== resultsBefore.cells) this.#placeBorders(results);
    if (other || results.measured !== resultsBefore.measured) this.#placeMeasures(results);
    if (other || relabel) this.#label(state, results);
    this.stage.wake();
  }

  /** How far along the path a place on the page is, in mesh units; null where it is not near. */
  alongAt(x: number, y: number): number | null {
    let nearest: number | null = null;
    let least = 14; // CSS pixels
    let walked = 0;
    for (let i = 0; i < this.#line.length; i += 3) {
      const place = new Vector3().fromArray(this.#line, i);
      if (i) walked += place.distanceTo(new Vector3().fromArray(this.#line, i - 3));
      const at = this.stage.onPage(place);
      const before = i ? this.stage.onPage(new Vector3().fromArray(this.#line, i - 3)) : null;
      if (!at || !before) continue;
      const [dx, dy] = [at.x - before.x, at.y - before.y];
      const part = Math.min(1, Math.max(0, ((x - before.x) * dx + (y - before.y) * dy) / (dx * dx + dy * dy || 1)));
      const away = Math.hypot(before.x + part * dx - x, before.y + part * dy - y);
      if (away >= least) continue;
      least = away;
      const length = place.distanceTo(new Vector3().fromArray(this.#line, i - 3));
      nearest = (walked - (1 - part) * length) * (this.#surface?.radius ?? 1);
    }
    return nearest;
  }

  /** The dot where somebody points at the path's profile. */
  #walk({ surface, path, along }: Results): void {
    this.#line = pointsOf(surface, path);
    const [place] = surface && path?.reachable && along !== null ? placesAlong(surface, path, [along]) : [];
    if (!place) return this.stage.remove(this.#walker);
    this.#walker.position.copy(place);
    this.#walker.fit(this.stage.size.width, this.stage.size.height);
    this.stage.add(this.#walker);
  }

  /** The handle under a pointer at a place on the page, the nearest first. */
  handleAt(x: number, y: number, touch: boolean): Handle | null {
    let nearest: Handle | null = null;
    let distance = touch ? REACH.touch : REACH.mouse;
    for (const { handle, marker } of this.#markers) {
      const at = handle && this.stage.onPage(marker.position);
      if (!at) continue;
      const away = Math.hypot(at.x - x, at.y - y);
      if (away < distance) [nearest, distance] = [handle, away];
    }
    return nearest;
  }

  hold(handle: Handle | null): void {
    for (const each of this.#markers) {
      each.marker.held = handle !== null && each.handle?.kind === handle.kind && each.handle.index === handle.index;
    }
    this.stage.wake();
  }

  /** Where the arrow starts, and the plane's normal there, as drawn. */
  arrowPlane(): { start: Vector3; normal: Vector3 } | null {
    const arrow = this.#state?.arrow;
    if (!arrow || !this.#surface?.has(arrow.from)) return null;
    return { start: this.#surface.placeOf(arrow.from), normal: this.#surface.normalOf(arrow.from.face) };
  }

  /** The labels that are seen, for an export that draws them. */
  get texts(): Labels['texts'] {
    return this.#labels.texts;
  }

  #placeMarkers(state: State, results: Results): void {
    const { trace, regions } = results;
    const surface = surfaceOf(state, results);
    // Markers stay while their points move: to make one is to make its shaders.
    const spare = this.#markers;
    this.#markers = [];
    const add = (kind: MarkerKind, place: Vector3, handle: Handle | null, colour?: string) => {
      const same = spare.findIndex(
        (each) =>
          each.marker.kind === kind && each.marker.colour === colour &&
          each.handle?.kind === handle?.kind && each.handle?.index === handle?.index,
      );
      const [kept] = same < 0 ? [] : spare.splice(same, 1);
      const marker = kept?.marker ?? new Marker(kind, colour);
      marker.position.copy(place);
      this.#markers.push({ handle, marker });
      if (kept) return;
      marker.fit(this.stage.size.width, this.stage.size.height);
      this.stage.add(marker);
    };
    if (surface) this.#placeAll(state, surface, { trace, regions }, add);
    for (const { marker } of spare) {
      this.stage.remove(marker);
      marker.dispose();
    }
  }

  #placeAll(state: State, surface: Surface, { trace, regions }: Pick<Results, 'trace' | 'regions'>, add: AddMarker): void {
    const at = (kind: 'source' | 'target' | 'via' | 'arrow' | 'loop', spot: Spot, index: number, colour?: string) => {
      if (surface.has(spot)) add(kind, surface.placeOf(spot), { kind, index }, colour);
    };
    const shown = byRegion(state.show) && state.sources.length > 1;
    state.sources.forEach((spot, index) => at('source', spot, index, shown ? hueOf(regions, index) : undefined));
    state.via.forEach((spot, index) => at('via', spot, index));
    if (state.target) at('target', state.target, 0);
    state.loop?.points.forEach((spot, index) => at('loop', spot, index));
    if (state.arrow) {
      at('arrow', state.arrow.from, 0);
      add('arrow', new Vector3(), { kind: 'tip', index: 0 });
      if (trace) add('end', new Vector3(...(surface.drawn([trace.to]) as unknown as [number, number, number])), null);
    }
  }

  #placeLines({ curves, painted }: State, { surface, lines }: Results): void {
    const drawn = (some: readonly Line[]) => some.map((line) => pointsOf(surface, { points: lines.get(line) ?? [] }));
    this.#walls.setLines(drawn(painted.walls));
    this.#curves.setLines(drawn(curves));
  }

  /** The bisectors of cells; a closed one comes back to its first point. */
  #placeBorders({ surface, cells }: Results): void {
    const lines = (cells?.answered.bisectors ?? []).map(({ points, closed }) => (closed ? [...points, points[0]!] : points));
    this.#borders.setLines(surface ? lines.map((points) => surface.drawn(points.map((xyz) => ({ xyz })))) : []);
  }

  #placeMeasures({ surface, measured }: Results): void {
    for (const line of this.#kept.splice(0)) {
      this.stage.remove(line);
      line.dispose();
    }
    for (const path of measured) {
      const line = new ThickLine({ core: '#ffe08a', casing: DARK, width: 2.2, order: 12 });
      line.setPoints(pointsOf(surface, path));
      this.#kept.push(line);
      this.stage.add(line);
    }
  }

  #label(state: State, { surface, path, measured, drawn, cells }: Results): void {
    const labels: Label[] = [];
    if (surface && path?.reachable && state.ticks) labels.push(...ticksAlong(surface, path));
    measured.forEach((kept, index) => {
      if (!surface || !kept?.reachable) return;
      const [place] = placesAlong(surface, kept, [kept.length! / 2]);
      if (place) labels.push({ text: `${letterOf(index)} ${lengthText(kept.length!)}`, place, strong: true, kept: true });
    });
    if (surface && drawn?.length != null && drawn.points.length > 1) {
      labels.push({ text: lengthText(drawn.length), place: this.#nearest(surface.drawn(drawn.points)), strong: true, kept: true });
    }
    for (const { site, area } of surface && cells ? cells.answered.cells : []) {
      labels.push({ text: lengthText(area), place: new Vector3().fromArray(surface!.drawn([site])), strong: false, kept: true });
    }
    this.#labels.show(labels);
  }

  /** Of drawn places that which is nearest to the eye, where a label is seen. */
  #nearest(drawn: Float32Array): Vector3 {
    const { position } = this.stage.camera;
    let nearest = new Vector3().fromArray(drawn);
    for (let i = 3; i < drawn.length; i += 3) {
      const place = new Vector3().fromArray(drawn, i);
      if (place.distanceToSquared(position) < nearest.distanceToSquared(position)) nearest = place;
    }
    return nearest;
  }

  /** The arrow has one length on the screen, however near one is. */
  #aim(): void {
    const arrow = this.#state?.arrow;
    const tip = this.#markers.find(({ handle }) => handle?.kind === 'tip')?.marker;
    const plane = this.arrowPlane();
    if (!arrow || !tip || !plane) return this.#shaft.setPoints(new Float32Array());
    const { start, normal } = plane;
    const length = ARROW * start.distanceTo(this.stage.camera.position);
    const direction = new Vector3(...arrow.direction).projectOnPlane(normal).normalize();
    tip.position.copy(start).addScaledVector(direction, length);
    tip.updateMatrixWorld();
    this.#shaft.setPoints(new Float32Array([...start.toArray(), ...tip.position.toArray()]));
  }
}

function pointsOf(surface: Surface | null, line: { points: Path['points'] } | null): Float32Array {
  return surface && line ? surface.drawn(line.points) : new Float32Array();
}

/** Labels at round distances, about six of them, and one at the end. */
function ticksAlong(surface: Surface, path: Path): Label[] {
  const length = path.length!;
  if (!(length > 0)) return [];
  const step = roundStep(length / 6);
  const levels: number[] = [];
  for (let n = 1; n * step < length - 0.35 * step; n++) levels.push(n * step);
  const places = placesAlong(surface, path, [...levels, length]);
  return places.map((place, index) => {
    const last = index === levels.length;
    return { text: last ? lengthText(length) : tickText(levels[index]!), place, strong: last };
  });
}

/** The places on a path at ascending lengths (mesh units) from its beginning. */
export function placesAlong(surface: Surface, { points }: Path, levels: readonly number[]): Vector3[] {
  const drawn = surface.drawn(points);
  const at = (index: number) => new Vector3().fromArray(drawn, 3 * index);
  const places: Vector3[] = [];
  let walked = 0;
  let next = 0;
  for (let i = 1; i < points.length && next < levels.length; i++) {
    const from = at(i - 1);
    const to = at(i);
    const part = from.distanceTo(to) * surface.radius;
    while (next < levels.length && (levels[next]! <= walked + part || i === points.length - 1)) {
      const along = part > 0 ? Math.min(1, (levels[next]! - walked) / part) : 1;
      places.push(new Vector3().lerpVectors(from, to, along));
      next++;
    }
    walked += part;
  }
  return places;
}
