/**
 * The state as the URL's fragment and back: short names, points as FACE,W0,W1, nothing
 * that has its usual value. By hand points may be written as the API has them, f:FACE,W0,W1
 * and v:VERTEX. What a link says wrongly is left out, and told where it is a point.
 */
import { LONGEST_TEXT, paintedIn, paintedText } from './painted.ts';
import {
  MOST_LINES, MOST_LOOP, MOST_MEASURES, MOST_SOURCES, MOST_VIA, START, UNPAINTED,
  type Arrow, type Axis, type Drawn, type Line, type Measure, type Painted, type Spot, type State,
} from './state.ts';

/** Rounds weights so that the link is short and says the same point as the page. */
export function spotOf(face: number, first: number, second: number): Spot {
  const a = Math.round(Math.min(1, Math.max(0, first)) * 1e6);
  const b = Math.min(1e6 - a, Math.round(Math.min(1, Math.max(0, second)) * 1e6));
  return { face, bary: [a / 1e6, b / 1e6, (1e6 - a - b) / 1e6] };
}

export function spotText({ face, bary, vertex }: Spot): string {
  return vertex === undefined ? `${face},${bary[0]},${bary[1]}` : `v:${vertex}`;
}

function spotIn(text: string | null | undefined): Spot | null {
  const vertex = /^v:(\d+)$/.exec(text ?? '')?.[1];
  if (vertex !== undefined) return { face: -1, bary: [1, 0, 0], vertex: Number(vertex) };
  const parts = numbersIn(text?.replace(/^f:/, ''), 3);
  if (!parts || !Number.isInteger(parts[0]) || parts[0]! < 0) return null;
  const [face, first, second] = parts as [number, number, number];
  if (first < 0 || second < 0 || first + second > 1 + 1e-9) return null;
  return spotOf(face, first, second);
}

function numbersIn(text: string | null | undefined, count: number): number[] | null {
  const parts = text?.split(',').map(Number) ?? [];
  return parts.length === count && parts.every(Number.isFinite) ? parts : null;
}

function numberIn(text: string | null, least: number, most: number): number | null {
  const value = text === null ? NaN : Number(text);
  return value >= least && value <= most ? value : null;
}

/** As many as the server takes. */
function pointsPerEdgeIn(text: string | null): number | null {
  const value = numberIn(text, 1, 64);
  return Number.isInteger(value) ? value : null;
}

const short = (value: number) => Number(value.toPrecision(7));

function arrowText({ from, direction, length }: Arrow): string {
  return [spotText(from), direction.map((part) => Number(part.toFixed(5))).join(','), short(length)].join(';');
}

function arrowIn(text: string | null): Arrow | null {
  const [start, towards, far] = text?.split(';') ?? [];
  const from = spotIn(start);
  const direction = numbersIn(towards, 3) as [number, number, number] | null;
  const length = Number(far);
  if (!from || !direction || !direction.some((part) => part !== 0) || !(length > 0) || !Number.isFinite(length)) return null;
  return { from, direction, length };
}

/** Empty, too, where it would be too long: `tooMuchPainted` says so. */
function regionText(painted: Painted): string {
  const text = paintedText(painted);
  return text.length > LONGEST_TEXT ? '' : text;
}

/** Whether more is painted than a link can hold. */
export function tooMuchPainted({ painted }: State): boolean {
  return paintedText(painted) !== regionText(painted);
}

/** Such as `closed;5,0.3,0.3;9,0.2,0.5`. */
export function lineText({ points, closed }: Line): string {
  return [...(closed ? ['closed'] : []), ...points.map(spotText)].join(';');
}

function lineIn(text: string): Line | null {
  const closed = text.startsWith('closed;');
  const parts = (closed ? text.slice(7) : text).split(';');
  const points = parts.map(spotIn).filter((spot) => spot !== null);
  const right = points.length === parts.length && points.length >= (closed ? 3 : 2) && points.length <= MOST_LOOP;
  return right ? { points, closed } : null;
}

function linesIn(all: URLSearchParams, name: string): readonly Line[] {
  return all.getAll(name).map(lineIn).filter((line) => line !== null).slice(0, MOST_LINES);
}

function drawnText({ kind, normal, points }: Drawn): string {
  return [kind, ...(normal ? [normal.map((part) => Number(part.toFixed(5))).join(',')] : []), ...points.map(spotText)].join(';');
}

function drawnIn(text: string | null): Drawn | null {
  const [kind, ...parts] = text?.split(';') ?? [];
  const planar = kind === 'plane' || kind === 'tape';
  if (!planar && kind !== 'open' && kind !== 'through' && kind !== 'around') return null;
  const normal = planar ? (numbersIn(parts.shift(), 3) as [number, number, number] | null) : null;
  if (planar && !normal?.some((part) => part !== 0)) return null;
  const points = parts.map(spotIn).filter((spot) => spot !== null);
  const least = { open: 1, through: 2, around: 3, plane: 1, tape: 1 }[kind];
  if (points.length !== parts.length || points.length < least || points.length > (planar ? 1 : MOST_LOOP)) return null;
  return { kind, points, normal };
}

function measureText({ from, via, to, method, pointsPerEdge, refine, painted }: Measure): string {
  const by = method === 'steiner' && pointsPerEdge !== null ? `${method}-${pointsPerEdge}` : method;
  const on = regionText(painted);
  const walls = painted.walls.map((wall) => `wall:${lineText(wall).replaceAll(';', '_')}`);
  return [by, refine ? 1 : 0, ...[from, ...via, to].map(spotText), ...walls, ...(on ? [on] : [])].join(';');
}

function measureIn(text: string): Measure | null {
  const [by, refine, ...places] = text.split(';');
  const [, method, perEdge] = /^([^]*?)(?:-(\d+))?$/.exec(by ?? '')!;
  const painted = paintedIn(places.at(-1) ?? '');
  if (painted) places.pop();
  const walls = [];
  for (let wall; (wall = /^wall:(.*)$/.exec(places.at(-1) ?? '')?.[1]) !== undefined; places.pop()) walls.unshift(lineIn(wall.replaceAll('_', ';')));
  if (walls.length > MOST_LINES || walls.includes(null)) return null;
  const spots = places.map(spotIn);
  if (!method || spots.length < 2 || spots.length > MOST_VIA + 2 || spots.some((spot) => !spot)) return null;
  const [from, ...rest] = spots as Spot[];
  const to = rest.pop()!;
  return { from: from!, via: rest, to, method, pointsPerEdge: pointsPerEdgeIn(perEdge ?? null), refine: refine === '1', painted: withWalls(painted ?? UNPAINTED, walls as Line[]) };
}

/** The fragment, without its `#`. */
export function linkOf(state: State): string {
  const all = new URLSearchParams();
  if (state.mesh) all.set('mesh', state.mesh);
  for (const spot of state.sources) all.append('from', spotText(spot));
  for (const spot of state.via) all.append('via', spotText(spot));
  if (state.target) all.set('to', spotText(state.target));
  if (state.arrow) all.set('arrow', arrowText(state.arrow));
  if (state.loop) all.set('loop', drawnText(state.loop));
  const [, on, faces] = /^(\w+):(.*)$/.exec(regionText(state.painted)) ?? [];
  if (on && faces) all.set(on, faces);
  for (const wall of state.painted.walls) all.append('wall', lineText(wall));
  for (const curve of state.curves) all.append('curve', lineText(curve));
  if (state.disc !== null) all.set('disc', `${short(state.disc)}`);
  for (const measure of state.measures) all.append('kept', measureText(measure));
  if (state.method !== START.method) all.set('method', state.method);
  if (state.pointsPerEdge !== null) all.set('points_per_edge', `${state.pointsPerEdge}`);
  if (!state.refine) all.set('refine', 'none');
  if (state.walking) all.set('walking', state.walking);
  if (state.show !== START.show) all.set('show', state.show);
  if (state.colours !== START.colours) all.set('colours', state.colours);
  if (state.lines !== START.lines) all.set('lines', `${state.lines}`);
  if (!state.ticks) all.set('ticks', '0');
  if (state.edges) all.set('edges', '1');
  if (state.up) all.set('up', state.up);
  if (state.camera) all.set('camera', state.camera.map((part) => Number(part.toFixed(4))).join(','));
  // Commas and semicolons may stand in a fragment; a link is for people's eyes, too.
  return all.toString().replaceAll('%2C', ',').replaceAll('%3B', ';');
}

const MESH_ID = /^[0-9a-f]{64}(~[0-9a-z]+)?$/;

function partsOf(fragment: string): URLSearchParams {
  return new URLSearchParams(fragment.replace(/^#/, ''));
}

/** Points of a fragment that cannot be read, as they stand there. */
export function strangeIn(fragment: string): string[] {
  const all = partsOf(fragment);
  const strange = ['from', 'via', 'to'].flatMap((name) => all.getAll(name).filter((text) => !spotIn(text)).map((text) => `${name}=${text}`));
  const more = all.getAll('from').length - MOST_SOURCES;
  return more > 0 ? [...strange, `${more} more sources than the server takes`] : strange;
}

/** What a fragment has in place of a mesh's id: its name, most likely. */
export function meshNameIn(fragment: string): string | null {
  const mesh = partsOf(fragment).get('mesh');
  return mesh && !MESH_ID.test(mesh) ? mesh : null;
}

function axisIn(text: string | null): Axis | null {
  return text === 'x' || text === 'y' || text === 'z' ? text : null;
}

function withWalls(painted: Painted, walls: readonly Line[]): Painted {
  return walls.length ? { ...painted, walls } : painted;
}

function regionIn(all: URLSearchParams, as: Painted['as']): Painted | null {
  return paintedIn(`${as}:${all.get(as)?.replace(/^faces:/, '') ?? ''}`);
}

/** The state that a fragment says, with or without its `#`. */
export function stateIn(fragment: string): State {
  const all = partsOf(fragment);
  const spots = (name: string) => all.getAll(name).map(spotIn).filter((spot) => spot !== null);
  const mesh = all.get('mesh');
  const show = all.get('show');
  const sources = spots('from').slice(0, MOST_SOURCES);
  return {
    ...START,
    // As right after it was placed: a click must not take the sources away.
    tool: sources.length ? 'target' : START.tool,
    mesh: mesh && MESH_ID.test(mesh) ? mesh : null,
    sources,
    via: spots('via').slice(0, MOST_VIA),
    target: spotIn(all.get('to')),
    arrow: arrowIn(all.get('arrow')),
    loop: drawnIn(all.get('loop')),
    painted: withWalls(regionIn(all, 'forbid') ?? regionIn(all, 'within') ?? UNPAINTED, linesIn(all, 'wall')),
    curves: linesIn(all, 'curve'),
    disc: numberIn(all.get('disc'), Number.MIN_VALUE, Number.MAX_VALUE),
    measures: all.getAll('kept').map(measureIn).filter((measure) => measure !== null).slice(0, MOST_MEASURES),
    method: all.get('method') ?? START.method,
    pointsPerEdge: pointsPerEdgeIn(all.get('points_per_edge')),
    refine: all.get('refine') !== 'none',
    show: show === 'regions' || show === 'cells' || show === 'error' ? show : START.show,
    colours: all.get('colours') === 'turbo' ? 'turbo' : START.colours,
    lines: Math.round(numberIn(all.get('lines'), 0, 100) ?? START.lines),
    ticks: all.get('ticks') !== '0',
    edges: all.get('edges') === '1',
    walking: axisIn(all.get('walking')),
    up: axisIn(all.get('up')),
    camera: numbersIn(all.get('camera'), 6),
  };
}
