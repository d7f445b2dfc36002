/**
 * The state as the URL's fragment and back: short names, points as FACE,W0,W1, nothing
 * that has its usual value. By hand points may be written as the API has them, f:FACE,W0,W1
 * and v:VERTEX. What a link says wrongly is left out, and told where it is a point.
 */
import { MOST_MEASURES, MOST_SOURCES, MOST_VIA, START, type Arrow, type Measure, type Spot, type State } from './state.ts';

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

function measureText({ from, via, to, method, pointsPerEdge, refine }: Measure): string {
  const by = method === 'steiner' && pointsPerEdge !== null ? `${method}-${pointsPerEdge}` : method;
  return [by, refine ? 1 : 0, ...[from, ...via, to].map(spotText)].join(';');
}

function measureIn(text: string): Measure | null {
  const [by, refine, ...places] = text.split(';');
  const [, method, perEdge] = /^([^]*?)(?:-(\d+))?$/.exec(by ?? '')!;
  const spots = places.map(spotIn);
  if (!method || spots.length < 2 || spots.length > MOST_VIA + 2 || spots.some((spot) => !spot)) return null;
  const [from, ...rest] = spots as Spot[];
  const to = rest.pop()!;
  return { from: from!, via: rest, to, method, pointsPerEdge: pointsPerEdgeIn(perEdge ?? null), refine: refine === '1' };
}

/** The fragment, without its `#`. */
export function linkOf(state: State): string {
  const all = new URLSearchParams();
  if (state.mesh) all.set('mesh', state.mesh);
  for (const spot of state.sources) all.append('from', spotText(spot));
  for (const spot of state.via) all.append('via', spotText(spot));
  if (state.target) all.set('to', spotText(state.target));
  if (state.arrow) all.set('arrow', arrowText(state.arrow));
  for (const measure of state.measures) all.append('kept', measureText(measure));
  if (state.method !== START.method) all.set('method', state.method);
  if (state.pointsPerEdge !== null) all.set('points_per_edge', `${state.pointsPerEdge}`);
  if (!state.refine) all.set('refine', 'none');
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

/** The state that a fragment says, with or without its `#`. */
export function stateIn(fragment: string): State {
  const all = partsOf(fragment);
  const spots = (name: string) => all.getAll(name).map(spotIn).filter((spot) => spot !== null);
  const mesh = all.get('mesh');
  const show = all.get('show');
  const up = all.get('up');
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
    measures: all.getAll('kept').map(measureIn).filter((measure) => measure !== null).slice(0, MOST_MEASURES),
    method: all.get('method') ?? START.method,
    pointsPerEdge: pointsPerEdgeIn(all.get('points_per_edge')),
    refine: all.get('refine') !== 'none',
    show: show === 'regions' || show === 'error' ? show : START.show,
    colours: all.get('colours') === 'turbo' ? 'turbo' : START.colours,
    lines: Math.round(numberIn(all.get('lines'), 0, 100) ?? START.lines),
    ticks: all.get('ticks') !== '0',
    edges: all.get('edges') === '1',
    up: up === 'x' || up === 'y' || up === 'z' ? up : null,
    camera: numbersIn(all.get('camera'), 6),
  };
}
