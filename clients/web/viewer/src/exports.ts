/**
 * What leaves the page as a file: the view with its labels and legend as PNG, the path as
 * GLB, JSON or CSV, the field as NPY, the list of measures as CSV.
 */
import type { GlbQuery, Path } from 'geodesicd-client';
import type { Access } from './access.ts';
import { colourAt } from './colour_maps.ts';
import { legendOf, type LegendText } from './legend.ts';
import { methodAndCosts } from './costs.ts';
import { meshName } from './mesh_names.ts';
import { letterOf } from './measures.ts';
import type { Overlay } from './overlay.ts';
import type { ExportKind } from './parts.ts';
import { regionsOf } from './painted.ts';
import { fieldQuestion, sourceOf, sourcesOf } from './questions.ts';
import type { Results } from './results.ts';
import { scaleOf } from './scale_bar.ts';
import { cellsOf, queryOf } from './shapes.ts';
import type { Stage } from './stage.ts';
import { resolvedSpot } from './spot_text.ts';
import type { State } from './state.ts';

export interface Exporting {
  readonly access: Access;
  readonly stage: Stage;
  readonly overlay: Overlay;
  readonly state: State;
  readonly results: Results;
}

/** Makes the file and hands it to the browser. Rejects as the client does. */
export async function exported(kind: ExportKind, from: Exporting): Promise<void> {
  const { results } = from;
  if (!results.surface) return;
  const name = meshName(results.surface.about).replace(/\.(glb|gltf|drc|obj|ply|stl)$/i, '').replace(/[\s/\\:*?"<>|]/g, '_');
  const file = await MAKERS[kind](from);
  if (file) save(file, kind === 'png' ? `${name}.png` : `${name}.${kind}`);
}

const MAKERS: Record<ExportKind, (from: Exporting) => Promise<Blob | null>> = {
  png: picture,
  'path.glb': async ({ access, state, results }) => {
    const { path, pathStart } = results;
    if (!path || !pathStart || !state.mesh) return null;
    const { via, to, refine } = path;
    const query = { from: sourceOf(pathStart), via: via.map(resolvedSpot), to: resolvedSpot(to), refine, ...methodAndCosts(state), ...regionsOf(state.painted) };
    return glb(access, state.mesh, { of: 'path', ...query });
  },
  'field.glb': async ({ access, state }) => {
    const query = { from: sourcesOf(state), colormap: state.colours, ...methodAndCosts(state), ...regionsOf(state.painted) };
    return glb(access, state.mesh!, { of: 'distance', ...query });
  },
  'loop.glb': async ({ access, state }) => {
    const asked = state.loop && queryOf(state, state.loop);
    if (!asked || asked.query !== 'loop' || !state.mesh) return null;
    const { query, ...rest } = asked;
    return glb(access, state.mesh, { of: query, ...rest });
  },
  'cells.glb': async ({ access, state }) => {
    const question = fieldQuestion(state);
    if (!question) return null;
    const { query, ...rest } = cellsOf(question, 0);
    return glb(access, question.mesh, { of: query, ...rest });
  },
  'path.json': async ({ results: { path } }) => {
    if (!path) return null;
    const { timing: _timing, cache: _cache, warnings: _warnings, ...answered } = path;
    return text(JSON.stringify(answered, null, 1), 'application/json');
  },
  'path.csv': async ({ results: { path } }) => (path ? text(pathCsv(path), 'text/csv') : null),
  'field.npy': async ({ access, state }) => {
    // As the server writes it: float64, more than the page keeps.
    const query = { from: sourcesOf(state), ...methodAndCosts(state), ...regionsOf(state.painted), format: 'npy' };
    const reply = await access.client.request({
      method: 'POST',
      path: `/v1/meshes/${state.mesh}/distance`,
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(query),
      idempotent: true,
    });
    return new Blob([reply.body], { type: 'application/x-npy' });
  },
  'measures.csv': async ({ state, results }) => {
    const rows = state.measures.map(({ method, refine, via }, index) => {
      const path = results.measured[index];
      return [letterOf(index), path?.length ?? '', method, refine ? 'shortest' : 'none', via.length].join(',');
    });
    return text(['measure,length,method,refine,via', ...rows, ''].join('\n'), 'text/csv');
  },
};

async function glb(access: Access, mesh: string, query: GlbQuery): Promise<Blob> {
  return new Blob([await access.client.glb(mesh, query)], { type: 'model/gltf-binary' });
}

/** A row a point: x, y, z and the distance walked, in mesh units; then face and weights. */
function pathCsv({ points }: Path): string {
  let walked = 0;
  const rows = points.map(({ xyz, face, bary }, index) => {
    const before = points[index - 1]?.xyz;
    if (before) walked += Math.hypot(...xyz.map((part, axis) => part - before[axis]!));
    return [...xyz, walked, face ?? '', ...(bary ?? ['', '', ''])].join(',');
  });
  return ['x,y,z,distance,face,w0,w1,w2', ...rows, ''].join('\n');
}

function text(content: string, type: string): Blob {
  return new Blob([content], { type });
}

function save(file: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(file);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** The page's background, the canvas, the labels, the legend and the scale on one picture. */
function picture({ stage, overlay, state, results }: Exporting): Promise<Blob | null> {
  const sheet = stage.picture((view) => {
    const made = document.createElement('canvas');
    made.width = view.width;
    made.height = view.height;
    const pen = made.getContext('2d')!;
    pen.fillStyle = styleOf('--ground');
    pen.fillRect(0, 0, made.width, made.height);
    pen.drawImage(view, 0, 0);
    const scale = view.width / stage.size.width;
    pen.scale(scale, scale);
    pen.textBaseline = 'middle';
    drawLabels(pen, overlay);
    const legend = legendOf(state, results);
    if (legend) drawLegend(pen, legend, stage.size.height - 64);
    if (results.surface) drawScale(pen, scaleOf(stage, results.surface), stage.size);
    return made;
  });
  return new Promise((resolve) => sheet.toBlob(resolve, 'image/png'));
}

type Pen = CanvasRenderingContext2D;

function styleOf(name: string): string {
  return getComputedStyle(document.body).getPropertyValue(name);
}

function setFont(pen: Pen, size: number, weight = 400): void {
  pen.font = `${weight} ${size}px system-ui, sans-serif`;
}

function drawLabels(pen: Pen, { texts }: Overlay): void {
  pen.textAlign = 'center';
  for (const { text: said, x, y, strong } of texts) {
    setFont(pen, strong ? 13 : 12, strong ? 700 : 500);
    const width = pen.measureText(said).width + 12;
    pen.fillStyle = 'rgba(16, 19, 26, 0.82)';
    pen.beginPath();
    pen.roundRect(x - width / 2, y - 32, width, 20, 6);
    pen.fill();
    pen.fillStyle = '#ffffff';
    pen.fillText(said, x, y - 21.5);
  }
}

function drawLegend(pen: Pen, legend: LegendText, top: number): void {
  const [left, width] = [24, 260];
  pen.fillStyle = styleOf('--text');
  pen.textAlign = 'left';
  setFont(pen, 13, 600);
  pen.fillText(legend.title, left, top - 14);
  setFont(pen, 12);
  pen.fillText(legend.note, left + width - pen.measureText(legend.note).width, top - 14);
  for (let x = 0; legend.map && x < width; x++) {
    pen.fillStyle = `rgb(${colourAt(legend.map, x / (width - 1)).join(' ')})`;
    pen.fillRect(left + x, top, 1.5, 12);
  }
  legend.ticks.forEach(({ at, text: said, colour }, index) => {
    const x = legend.map ? left + at * width : left + index * 30;
    if (colour) {
      pen.fillStyle = colour;
      pen.fillRect(x, top, 24, 12);
    }
    pen.fillStyle = styleOf('--text');
    pen.textAlign = !legend.map || at < 0.03 ? 'left' : at > 0.97 ? 'right' : 'center';
    pen.fillText(said, x, top + 24);
  });
}

/** At the right below: the legend is at the left. */
function drawScale(pen: Pen, { pixels, text: said }: { pixels: number; text: string }, { width, height }: Stage['size']): void {
  const [right, bottom] = [width - 24, height - 28];
  setFont(pen, 12);
  pen.fillStyle = pen.strokeStyle = styleOf('--text');
  pen.textAlign = 'right';
  pen.fillText(said, right, bottom - 18);
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(right - pixels, bottom - 8);
  pen.lineTo(right - pixels, bottom);
  pen.lineTo(right, bottom);
  pen.lineTo(right, bottom - 8);
  pen.stroke();
}
