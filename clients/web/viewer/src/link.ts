/**
 * The state as the URL's fragment and back: short names, points as FACE,W0,W1, nothing
 * that has its usual value. By hand points may be written as the API has them, f:FACE,W0,W1
 * and v:VERTEX. What a link says wrongly is left out, and told where it is a point.
 */
import { LONGEST_TEXT, paintedIn, paintedText } from './painted.ts';
import { lineIn, lineText, numbersIn, spotIn, spotText } from './spot_text.ts';
import {
  byCost, isPlanar, MOST_LINES, MOST_LOOP, MOST_MEASURES, MOST_SOURCES, MOST_VIA, START, UNPAINTED,
  type Arrow, type Axis, type Drawn, type Line, type Measure, type Painted, type Show, type Spot, type State,
} from './state.ts';
import { walkingIn, walkingText } from './costs.ts';

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

/** So long texts of kept paths go into a link together. */
const LONGEST_KEPT = 300_000;

function fits(painted: Painted): boolean {
  return paintedText(painted).length <= LONGEST_TEXT;
}

/** The list's paths as a link has them: without those for which it has no room. A path without its painting would be another. */
function keptTexts(measures: readonly Measure[]): string[] {
  let room = LONGEST_KEPT;
  const texts = measures.filter(({ painted }) => fits(painted)).map(measureText);
  return texts.filter((text) => (room -= text.length) >= 0);
}

/** Whether more is painted than a link can hold. */
export function tooMuchPainted({ painted, measures }: State): boolean {
  return !fits(painted) || keptTexts(measures).length < measures.length;
}

function linesIn(all: URLSearchParams, name: string): readonly Line[] {
  return all.getAll(name).map(lineIn).filter((line) => line !== null).slice(0, MOST_LINES);
}

function drawnText({ kind, normal, points }: Drawn): string {
  return [kind, ...(normal ? [normal.map((part) => Number(part.toFixed(5))).join(',')] : []), ...points.map(spotText)].join(';');
}

function drawnIn(text: string | null): Drawn | null {
  const [kind, ...parts] = text?.split(';') ?? [];
  if (kind !== 'open' && kind !== 'through' && kind !== 'around' && kind !== 'plane' && kind !== 'tape') return null;
  const planar = isPlanar({ kind });
  const normal = planar ? (numbersIn(parts.shift(), 3) as [number, number, number] | null) : null;
  if (planar && !normal?.some((part) => part !== 0)) return null;
  const points = parts.map(spotIn).filter((spot) => spot !== null);
  const least = { open: 1, through: 2, around: 3, plane: 1, tape: 1 }[kind];
  if (points.length !== parts.length || points.length < least || points.length > (planar ? 1 : MOST_LOOP)) return null;
  return { kind, points, normal };
}

function measureText({ from, via, to, method, pointsPerEdge, refine, painted }: Measure): string {
  const by = method === 'steiner' && pointsPerEdge !== null ? `${method}-${pointsPerEdge}` : method;
  const on = paintedText(painted);
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
  const [, on, faces] = /^(\w+):(.*)$/.exec(fits(state.painted) ? paintedText(state.painted) : '') ?? [];
  if (on && faces) all.set(on, faces);
  for (const wall of state.painted.walls) all.append('wall', lineText(wall));
  for (const curve of state.curves) all.append('curve', lineText(curve));
  if (state.disc !== null) all.set('disc', `${short(state.disc)}`);
  for (const text of keptTexts(state.measures)) all.append('kept', text);
  if (state.method !== START.method) all.set('method', state.method);
  if (state.pointsPerEdge !== null) all.set('points_per_edge', `${state.pointsPerEdge}`);
  if (!state.refine) all.set('refine', 'none');
  if (state.walking) all.set('walking', walkingText(state.walking));
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

/** Cells and errors are about lengths. */
function showIn(text: string | null, costs: boolean): Show {
  return text === 'regions' || (!costs && (text === 'cells' || text === 'error')) ? text : START.show;
}

function withWalls(painted: Painted, walls: readonly Line[]): Painted {
  return walls.length ? { ...painted, walls } : painted;
}

function regionIn(all: URLSearchParams, as: Painted['as']): Painted | null {
  return paintedIn(`${as}:${all.get(as)?.replace(/(^|\*)faces:/, '$1') ?? ''}`);
}

/** The state that a fragment says, with or without its `#`. Least costs begin at points: with curves there are none. */
export function stateIn(fragment: string): State {
  const all = partsOf(fragment);
  const spots = (name: string) => all.getAll(name).map(spotIn).filter((spot) => spot !== null);
  const mesh = all.get('mesh');
  const sources = spots('from').slice(0, MOST_SOURCES);
  const curves = linesIn(all, 'curve');
  const region = regionIn(all, 'forbid') ?? regionIn(all, 'within') ?? (curves.length ? null : regionIn(all, 'weights')) ?? UNPAINTED;
  const costs = { walking: curves.length ? null : walkingIn(all.get('walking')), painted: withWalls(region, linesIn(all, 'wall')) };
  return {
    ...START,
    ...costs,
    // As right after it was placed: a click must not take the sources away.
    tool: sources.length ? 'target' : START.tool,
    mesh: mesh && MESH_ID.test(mesh) ? mesh : null,
    sources,
    via: spots('via').slice(0, MOST_VIA),
    target: spotIn(all.get('to')),
    arrow: arrowIn(all.get('arrow')),
    loop: drawnIn(all.get('loop')),
    curves,
    disc: numberIn(all.get('disc'), Number.MIN_VALUE, Number.MAX_VALUE),
    measures: all.getAll('kept').map(measureIn).filter((measure) => measure !== null).slice(0, MOST_MEASURES),
    method: all.get('method') ?? START.method,
    pointsPerEdge: pointsPerEdgeIn(all.get('points_per_edge')),
    refine: all.get('refine') !== 'none',
    show: showIn(all.get('show'), byCost(costs)),
    colours: all.get('colours') === 'turbo' ? 'turbo' : START.colours,
    lines: Math.round(numberIn(all.get('lines'), 0, 100) ?? START.lines),
    ticks: all.get('ticks') !== '0',
    edges: all.get('edges') === '1',
    up: axisIn(all.get('up')),
    camera: numbersIn(all.get('camera'), 6),
  };
}
