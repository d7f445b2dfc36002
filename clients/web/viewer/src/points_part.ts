/** The panel's part for points: what the next click places, and what stands where. */
import { element } from './element.ts';
import { lengthText } from './numbers.ts';
import { choice, removeButton } from './panel.ts';
import type { Parts } from './parts.ts';
import { hueOf } from './regions.ts';
import type { Results } from './results.ts';
import { byRegion, MOST_SOURCES, type State, type Tool } from './state.ts';

/** Rows of sources in the panel, unless all are asked for. */
const LISTED = 6;

export const TOOLS: readonly { value: Tool; label: string; icon: string; title: string }[] = [
  { value: 'source', label: 'Source', icon: 'M10 10m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0M10 3v2M10 15v2M3 10h2M15 10h2', title: 'Where distances begin (1)' },
  { value: 'add', label: 'Add', icon: 'M10 5v10M5 10h10', title: 'One more source (2, or Shift and click)' },
  { value: 'target', label: 'Target', icon: 'M10 10m-6 0a6 6 0 1 0 12 0a6 6 0 1 0-12 0M10 10m-1.6 0a1.6 1.6 0 1 0 3.2 0a1.6 1.6 0 1 0-3.2 0', title: 'Where the path ends (3)' },
  { value: 'via', label: 'Via', icon: 'M3 14c4 0 3-8 7-8s3 8 7 8', title: 'Where the path passes (4)' },
  { value: 'arrow', label: 'Straight', icon: 'M4 16L16 4M9 4h7v7', title: 'Straight ahead on the surface (5)' },
  { value: 'loop', label: 'Loop', icon: 'M10 4c5 0 7 2.5 7 6s-3 6-7 6s-7-2.5-7-6s2-6 7-6M10 4m-1.4 0a1.4 1.4 0 1 0 2.8 0a1.4 1.4 0 1 0-2.8 0', title: 'A closed line through points, or a tape round one (6)' },
  { value: 'brush', label: 'Brush', icon: 'M16.5 3.5L9 11M9 11c-2.5-.5-4 .8-4.2 2.6C4.6 15.2 4 16 3 16.5c3 1 6.5.3 7-2.5c.2-1-.2-2-1-3', title: 'Paint faces that are forbidden, the only ones, or weighted (7)' },
];

const DRAG_OVER = { forbid: 'faces to forbid them', within: 'the faces that are to be left', weights: 'faces to give them a weight' } as const;

/** What a click, or a finger's tap, does now, in words. */
export function hintOf({ tool, sources, target, arrow, loop, painted, curves, erasing, mesh }: State): string | null {
  const [click, Click] = matchMedia('(pointer: coarse)').matches ? ['tap', 'Tap'] : ['click', 'Click'];
  if (!mesh) return 'Drop a mesh here: .glb, .gltf, .drc, .obj, .ply or .stl';
  if (tool === 'source' && !sources.length && !curves.length) return `${Click} the surface to place a source`;
  if (tool === 'target' && sources.length + curves.length && !target) return `Now ${click} a target, then drag it`;
  if (tool === 'add') return `${Click} to add a source`;
  if (tool === 'via') return `${Click} where the path should pass`;
  if (tool === 'arrow' && !arrow) return `${Click} where to go straight ahead from`;
  if (tool === 'arrow') return 'Drag the arrow’s head to turn it';
  if (tool === 'loop' && loop?.kind !== 'open') return `${Click} points of a loop, one after the other`;
  if (tool === 'loop' && loop!.points.length > 1) return `Go on, or ${click} the first point to close the loop`;
  if (tool === 'loop') return `${Click} the next point, or lay a tape round this one`;
  if (tool === 'brush' && erasing) return 'Drag over painted faces to erase them';
  if (tool === 'brush' && !painted.faces.length) return `Drag over ${DRAG_OVER[painted.as]}; beside the mesh to turn it`;
  return null;
}

export function pointsPart({ state, results, actions }: Parts): HTMLElement {
  const tools = choice('What a click places', TOOLS, (tool) => state.set({ tool }));
  const list = element('ul', { className: 'points' });
  const clear = element('button', { type: 'button', className: 'quiet', onclick: actions.clear }, 'Clear points');
  const root = element('section', { className: 'points-part' }, element('h2', { className: 'out-of-sight' }, 'Points'), tools.root, list, clear);

  const without = <T>(some: readonly T[], index: number) => some.filter((_, other) => other !== index);
  /** With its number where there are several. */
  const named = (name: string, index: number, { length }: readonly unknown[]) => (length > 1 ? `${name} ${index + 1}` : name);
  const row = (kind: string, name: string, remove: () => void, region?: string) => {
    const made = element(
      'li',
      { className: `point ${kind}${region ? ' region' : ''}` },
      element('i', { aria: { hidden: 'true' } }),
      name,
      removeButton(name, remove),
    );
    if (region) made.style.setProperty('--region', region);
    return made;
  };
  let all = false;
  const listed = (now: State) => (all ? now.sources.length : Math.min(LISTED, now.sources.length));
  const more = (now: State) => {
    if (now.sources.length <= LISTED) return [];
    const text = all ? `Only the first ${LISTED} sources` : `and ${now.sources.length - LISTED} sources more`;
    const button = element('button', { type: 'button', className: 'quiet', aria: { expanded: `${all}` } }, text);
    button.onclick = () => {
      all = !all;
      show(state.value);
      list.querySelector<HTMLElement>('.more button')?.focus();
    };
    return [element('li', { className: 'more' }, button)];
  };
  const show = (now: State) => {
    tools.set(now.tool);
    tools.enable('add', now.sources.length + now.curves.length > 0 && now.sources.length < MOST_SOURCES);
    const several = now.sources.length > 1;
    const rows = [
      ...now.sources.slice(0, listed(now)).map((_, index) =>
        row(
          'source',
          named('Source', index, now.sources),
          () => state.set({ sources: without(state.value.sources, index) }),
          several && byRegion(now.show) ? hueOf(results.value.regions, index) : undefined,
        ),
      ),
      ...more(now),
      ...now.via.map((_, index) =>
        row('via', named('Via', index, now.via), () => state.set({ via: without(state.value.via, index) })),
      ),
    ];
    if (now.target) rows.push(row('target', 'Target', () => state.set({ target: null })));
    if (now.arrow) rows.push(row('arrow', 'Arrow', () => state.set({ arrow: null })));
    const { curves } = now;
    const { walls } = now.painted;
    rows.push(
      ...curves.map((_, index) => row('source', named('Curve', index, curves), () => state.set({ curves: without(state.value.curves, index) }))),
      ...walls.map((_, index) => row('wall', named('Wall', index, walls), () => {
        const { painted } = state.value;
        state.set({ painted: { ...painted, walls: without(painted.walls, index) } });
      })),
    );
    if (now.loop) rows.push(row('loop', 'Loop', () => state.set({ loop: null })));
    list.replaceChildren(...rows);
    clear.hidden = rows.length === 0;
  };
  state.listen((now, before) => {
    // Only numbers count: while a point is dragged, its row stays, and the focus in it.
    const counts = (of: State) => [of.tool, of.show, of.sources.length, of.via.length, !!of.target, !!of.arrow, !!of.loop, of.curves.length, of.painted.walls.length].join();
    if (counts(now) !== counts(before)) show(now);
  });
  const hues = ({ regions }: Results) => regions?.colours.slice(0, listed(state.value)).join();
  results.listen((now, before) => {
    if (hues(now) !== hues(before)) show(state.value);
  });
  show(state.value);
  return root;
}

/** The part for a straightest geodesic: how far, and where it ended. */
export function arrowPart({ state, results }: Parts): HTMLElement {
  const slider = element('input', { type: 'range', min: '0', max: '1000', id: 'ahead' });
  const value = element('output', null);
  const said = element('p', { className: 'facts' });
  const root = element(
    'section',
    { className: 'arrow-part', hidden: true },
    element('div', { className: 'labelled' }, element('label', { htmlFor: 'ahead' }, 'Straight ahead for'), value),
    slider,
    said,
  );
  // Squared, so that short lengths can be told apart; at most around the mesh four times.
  const most = () => 25 * (results.value.surface?.radius ?? 1);
  slider.oninput = () => {
    const { arrow } = state.value;
    if (arrow) state.set({ arrow: { ...arrow, length: Math.max(1e-3, (Number(slider.value) / 1000) ** 2) * most() } });
  };
  const WHY = {
    length: 'Ends at its full length',
    boundary: 'Ends at the boundary',
    vertex: 'Ends at a vertex where faces meet in nothing else',
    non_manifold: 'Ends where more than two faces meet',
  };
  const show = () => {
    const { arrow } = state.value;
    const { trace } = results.value;
    root.hidden = !arrow;
    if (!arrow) return;
    slider.value = `${1000 * Math.sqrt(Math.min(1, arrow.length / most()))}`;
    value.textContent = lengthText(arrow.length);
    said.textContent = trace ? `${WHY[trace.end]}, after ${lengthText(trace.length)}` : '';
  };
  state.listen((now, before) => now.arrow !== before.arrow && show());
  results.listen((now, before) => (now.trace !== before.trace || now.surface !== before.surface) && show());
  return root;
}
