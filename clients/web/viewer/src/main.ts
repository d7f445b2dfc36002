/**
 * The page: makes its parts and ties them together. The state says what is wanted, the
 * conductor gets it from the server, stage, overlay, legend and panel show it, and the
 * link carries it away and back.
 */
import { Vector3 } from 'three';
import { Access } from './access.ts';
import { Conductor } from './conductor.ts';
import { Connection } from './connection.ts';
import { element } from './element.ts';
import { exported } from './exports.ts';
import { exportPart } from './export_part.ts';
import { Gestures } from './gestures.ts';
import { Legend } from './legend.ts';
import { linkOf, stateIn } from './link.ts';
import { lookPart } from './look_part.ts';
import { measureList } from './measure_list.ts';
import { fileEntrance, Meshes } from './meshes.ts';
import { meshPart } from './mesh_part.ts';
import { troubleOf } from './messages.ts';
import { methodPart } from './method_part.ts';
import { Notices } from './notices.ts';
import { Overlay } from './overlay.ts';
import { Panel } from './panel.ts';
import type { Actions } from './parts.ts';
import { Picking } from './picking.ts';
import { arrowPart, hintOf, pointsPart, TOOLS } from './points_part.ts';
import { resultPart } from './result_part.ts';
import { NOTHING, type Results } from './results.ts';
import { shortcuts } from './shortcuts.ts';
import { Stage } from './stage.ts';
import { Store, WITHOUT_POINTS, type State } from './state.ts';
import type { Surface } from './surface.ts';
import { SurfaceView } from './surface_view.ts';
import { ThemeSwitch } from './theme.ts';

const state = new Store<State>(stateIn(location.hash));
const results = new Store<Results>(NOTHING);
const notices = new Notices();

try {
  start();
} catch (error) {
  document.body.dataset['state'] = 'failed';
  notices.trouble({
    title: 'This page cannot draw here',
    advice: 'It needs WebGL 2, which this browser does not offer or has switched off. The API works without it.',
    detail: String(error),
  });
}

function start(): void {
  const gestures = new Gestures();
  const stage = new Stage((canvas) => gestures.attach(canvas));
  document.body.prepend(stage.canvas);
  const picking = new Picking();
  const view = new SurfaceView(stage);
  const overlay = new Overlay(stage, picking);
  const access = new Access(() => void begin());
  const connection = new Connection(() => access.probe, notices);
  const conductor = new Conductor(access, state, results, notices, connection);
  const meshes = new Meshes(access, results, notices, connection);
  const entrance = fileEntrance((file) => void take(file));
  const theme = new ThemeSwitch((clay) => view.setClay(clay));

  const actions: Actions = {
    open: entrance.open,
    chooseMesh: (id) => void choose(id),
    compare: () => conductor.compare(),
    clear: () => state.set({ sources: [], via: [], target: null, arrow: null, tool: 'source', show: 'distance' }),
    keep: () => {
      const { path } = results.value;
      const { sources, via, target, method, refine, measures } = state.value;
      if (!path?.reachable || !target || !sources.length || measures.length >= 50) return;
      // Several sources: the one that the path begins at.
      const { face, bary } = path.from;
      const from = sources.find((spot) => spot.face === face) ?? { face: face!, bary: bary as unknown as [number, number, number] };
      const measure = { from, via, to: target, method, refine };
      conductor.keep(measure, path);
      state.set({ measures: [...measures, measure] });
    },
    copyLink: () => void copyLink(),
    exported: (kind) => {
      exported(kind, { access, stage, overlay, state: state.value, results: results.value }).catch((error: unknown) => {
        if (!connection.explains(error)) notices.trouble(troubleOf(error), access.remedy(error));
      });
    },
  };
  const parts = { state, results, actions };

  const showKeys = shortcuts([
    {
      title: 'Points',
      keys: [
        { keys: 'Click', does: 'Place what the tool says' },
        { keys: 'Shift Click', does: 'One more source' },
        { keys: 'Drag', does: 'Move a point along the surface; elsewhere turn the view' },
        ...TOOLS.map(({ value, label }, index) => ({ keys: `${index + 1}`, does: `Tool: ${label}`, run: () => state.set({ tool: value }) })),
        { keys: 'K', does: 'Keep the path in the list', run: actions.keep },
        { keys: 'X', does: 'Clear the points', run: actions.clear },
      ],
    },
    {
      title: 'View',
      keys: [
        { keys: '← ↑ → ↓', does: 'Turn, with the mesh in focus' },
        { keys: '+ −', does: 'Nearer and farther' },
        { keys: 'Enter', does: 'Place a point at the cross in the middle' },
        { keys: 'F', does: 'All of the mesh', run: fit },
        { keys: 'U', does: 'Another axis up: y, z, x', run: nextUp },
        { keys: 'P', does: 'Fold the panel', run: () => panel.toggle() },
        { keys: 'T', does: 'Dark or light', run: () => theme.toggle() },
      ],
    },
    {
      title: 'Field',
      keys: [
        { keys: 'C', does: 'Other colours', run: () => state.set({ colours: state.value.colours === 'turbo' ? 'viridis' : 'turbo' }) },
        { keys: '[', does: 'Fewer isolines', run: () => state.set({ lines: Math.max(0, state.value.lines - 4) }) },
        { keys: ']', does: 'More isolines', run: () => state.set({ lines: Math.min(60, state.value.lines + 4) }) },
        { keys: 'L', does: 'Distances along the path', run: () => state.set({ ticks: !state.value.ticks }) },
        { keys: 'R', does: 'Pull the path straight', run: () => state.set({ refine: !state.value.refine }) },
        { keys: 'M', does: 'Next method', run: nextMethod },
        { keys: 'O', does: 'Open a file', run: entrance.open },
        { keys: 'Escape', does: 'Stop what is under way', run: () => conductor.stop() },
        { keys: '?', does: 'This sheet', run: () => showKeys() },
      ],
    },
  ]);

  let ready = false;
  const panel = new Panel(
    [
      { label: 'Dark or light', icon: 'M10 3a7 7 0 1 0 7 7a5.5 5.5 0 0 1-7-7', run: () => theme.toggle() },
      { label: 'Keys and gestures', icon: 'M7.5 7.5a2.5 2.5 0 1 1 3.6 2.2c-.8.4-1.1.9-1.1 1.8M10 14.5v.5', run: () => showKeys() },
    ],
    [
      meshPart(parts), pointsPart(parts), resultPart(parts), arrowPart(parts),
      lookPart(parts), methodPart(parts), measureList(parts), exportPart(parts),
    ],
    (right, bottom) => {
      stage.cover(right, bottom);
      document.body.style.setProperty('--covered-right', `${right}px`);
      document.body.style.setProperty('--covered-bottom', `${bottom}px`);
      if (ready) gestures.centre();
    },
  );
  const legend = new Legend();
  gestures.use({
    stage,
    overlay,
    picking,
    state,
    surface: () => results.value.surface,
    dragging: (handle) => { view.still = handle?.kind === 'source'; },
    full: () => notices.trouble({ title: 'No more sources', advice: 'The page has colours for eight. The API takes a thousand.', detail: '' }),
  });
  ready = true;
  gestures.centre();

  state.listen((now, before) => {
    view.follow(now, before, results.value, results.value);
    overlay.follow(now, before, results.value, results.value);
    legend.follow(now, results.value);
    notices.hint(hintOf(now));
    if (now.measures !== before.measures || now.mesh !== before.mesh) notices.clearTroubles();
    writeLink();
  });
  results.listen((now, before) => {
    view.follow(state.value, state.value, now, before);
    overlay.follow(state.value, state.value, now, before);
    legend.follow(state.value, now);
  });
  connection.onBack(() => void begin());
  stage.onTurned(() => state.set({ camera: stage.view }));
  addEventListener('hashchange', () => void follow(stateIn(location.hash)));

  /** Writes the link now and then: browsers allow a hundred times in half a minute. */
  let writing = 0;
  function writeLink(): void {
    clearTimeout(writing);
    writing = window.setTimeout(() => history.replaceState(null, '', `#${linkOf(state.value)}`), 250);
  }

  async function copyLink(): Promise<void> {
    state.set({ camera: stage.view });
    const link = new URL(`#${linkOf(state.value)}`, location.href).href;
    history.replaceState(null, '', link);
    try {
      await navigator.clipboard.writeText(link);
      notices.hint('The link is on the clipboard');
    } catch {
      notices.hint('The link is in the address bar'); // clipboards need https or localhost
    }
    setTimeout(() => notices.hint(hintOf(state.value)), 2500);
  }

  function fit(): void {
    const { surface } = results.value;
    if (!surface) return;
    const box = surface.geometry.boundingBox ?? (surface.geometry.computeBoundingBox(), surface.geometry.boundingBox!);
    stage.fit(box.getSize(new Vector3()), state.value.up);
    state.set({ camera: null });
  }

  /** From where the state says; without that at all of the mesh. */
  function look(camera: State['camera']): void {
    fit(); // for the axis that is up, too
    if (!camera) return;
    stage.view = camera;
    state.set({ camera });
  }

  function nextUp(): void {
    const axes = ['y', 'z', 'x'] as const;
    const now = axes.findIndex((axis) => stage.camera.up[axis] === 1);
    state.set({ up: axes[(now + 1) % axes.length]! });
    fit();
  }

  function nextMethod(): void {
    const names = results.value.methods.map(({ name }) => name);
    const next = names[(names.indexOf(state.value.method as never) + 1) % names.length];
    if (next) state.set({ method: next });
  }

  /** Another mesh, without the points of the one before. */
  async function choose(id: string): Promise<void> {
    if (!id || (id === state.value.mesh && results.value.surface?.id === id)) return;
    state.set({ ...WITHOUT_POINTS, mesh: id, up: null, camera: null });
    await show();
  }

  async function take(file: File): Promise<void> {
    notices.clearTroubles();
    const id = await meshes.upload(file);
    if (id) await choose(id);
  }

  /** A whole state, from a link. */
  async function follow(wanted: State): Promise<void> {
    if (linkOf(wanted) === linkOf(state.value)) return;
    const other = wanted.mesh !== state.value.mesh;
    state.set(wanted);
    if (other) await show();
    else look(wanted.camera);
  }

  /** Loads the state's mesh and looks at it as the state says. */
  async function show(): Promise<void> {
    const { mesh, camera } = state.value;
    if (!mesh) return;
    document.body.dataset['state'] = 'loading';
    const present = results.value.surface;
    if (present?.id === mesh) dropForeignPoints(present);
    else if (!(await meshes.load(mesh, dropForeignPoints))) {
      if (state.value.mesh === mesh) document.body.dataset['state'] = 'failed';
      return;
    }
    const surface = results.value.surface!;
    look(camera);
    document.title = `${surfaceName()} · geodesicd`;
    const drawn = nextPicture();
    await picking.take(surface);
    await drawn;
    document.body.dataset['state'] = 'ready';
  }

  /** Resolves when what is on the stage now has been drawn: two frames on. */
  function nextPicture(): Promise<void> {
    stage.wake();
    return new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => {
      performance.mark('geodesicd:picture'); // to be measured from outside
      resolve();
    })));
  }

  function surfaceName(): string {
    return results.value.meshes.find(({ id }) => id === state.value.mesh)?.parts[0]?.name || 'mesh';
  }

  /** A link may have been mended by hand: points that the mesh does not have are told and left out. */
  function dropForeignPoints(surface: Surface): void {
    const { sources, via, target, arrow, measures } = state.value;
    const all = [...sources, ...via, target, arrow?.from].filter((spot) => spot != null);
    if (all.every((spot) => surface.has(spot))) return;
    state.set({
      sources: sources.filter((spot) => surface.has(spot)),
      via: via.filter((spot) => surface.has(spot)),
      target: target && surface.has(target) ? target : null,
      arrow: arrow && surface.has(arrow.from) ? arrow : null,
      measures: measures.filter(({ from, to }) => surface.has(from) && surface.has(to)),
    });
    notices.trouble({
      title: 'Some points of this link are not on the mesh',
      advice: 'They were left out. The link may belong to another mesh.',
      detail: '',
    });
  }

  /** The first questions, and the same again when the server has come back. */
  async function begin(): Promise<void> {
    const { mesh } = state.value;
    const asked = mesh && results.value.surface?.id !== mesh ? show() : null;
    try {
      const [methods] = await Promise.all([access.client.methods(), meshes.list()]);
      results.set({ methods });
      conductor.askAgain();
    } catch (error) {
      if (!connection.explains(error)) notices.trouble(troubleOf(error), access.remedy(error));
    }
    await asked;
    const { first } = meshes;
    if (!state.value.mesh && first) {
      state.set({ mesh: first });
      await show();
    }
    if (!state.value.mesh) document.body.dataset['state'] = 'empty';
  }

  document.body.append(element('div', { className: 'drop-zone', aria: { hidden: 'true' } }, 'Drop to upload'));
  notices.hint(hintOf(state.value));
  void begin();
}
