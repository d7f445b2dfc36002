/**
 * The page: makes its parts and ties them together. The state says what is wanted, the
 * conductor gets it from the server, stage, overlay, legend and panel show it, and the
 * link carries it away and back.
 */
import { Vector3 } from 'three';
import type { Reading } from 'geodesicd-client';
import { Access } from './access.ts';
import { Conductor } from './conductor.ts';
import { Connection } from './connection.ts';
import { ask } from './dialog.ts';
import { element } from './element.ts';
import { fileEntrance, type Dropped } from './entrance.ts';
import { exported } from './exports.ts';
import { exportPart } from './export_part.ts';
import { Failures } from './failures.ts';
import { Gestures } from './gestures.ts';
import { History } from './history.ts';
import { Legend } from './legend.ts';
import { linkOf, stateIn } from './link.ts';
import { lookPart } from './look_part.ts';
import { measureList } from './measure_list.ts';
import { importPart } from './import_part.ts';
import { Meshes } from './meshes.ts';
import { meshName, nameFault } from './mesh_names.ts';
import { meshPart } from './mesh_part.ts';
import { troubleOf } from './messages.ts';
import { methodPart } from './method_part.ts';
import { Notices } from './notices.ts';
import { countText, lengthText } from './numbers.ts';
import { Overlay } from './overlay.ts';
import { Panel } from './panel.ts';
import type { Actions } from './parts.ts';
import { Picking } from './picking.ts';
import { Preview } from './preview.ts';
import { placePart } from './place_part.ts';
import { arrowPart, hintOf, pointsPart, TOOLS } from './points_part.ts';
import { profilePart } from './profile_part.ts';
import { resultPart } from './result_part.ts';
import { NOTHING, type Results } from './results.ts';
import { shortcuts } from './shortcuts.ts';
import { tooLarge } from './sources_file.ts';
import { NoWebGL, Stage } from './stage.ts';
import { MOST_MEASURES, MOST_SOURCES, START, Store, WITHOUT_POINTS, type Axis, type Spot, type State } from './state.ts';
import { ScaleBar } from './scale_bar.ts';
import type { Surface } from './surface.ts';
import { SurfaceView } from './surface_view.ts';
import { ThemeSwitch } from './theme.ts';
import { pointsInFile, pointsInLine, pointText, spotsOf, type Typed } from './typed_points.ts';
import { rememberUp, saysUp, upOf } from './upright.ts';

const state = new Store<State>(stateIn(location.hash));
const results = new Store<Results>(NOTHING);
const notices = new Notices();

try {
  start();
} catch (error) {
  document.body.dataset['state'] = 'failed';
  notices.trouble(error instanceof NoWebGL ? {
    title: 'This page cannot draw here',
    advice: 'It needs WebGL 2, which this browser does not offer or has switched off. The API works without it.',
    detail: error.message,
  } : troubleOf(error));
}

function start(): void {
  const gestures = new Gestures();
  const stage = new Stage((canvas) => gestures.attach(canvas));
  document.body.prepend(stage.canvas);
  const picking = new Picking();
  const view = new SurfaceView(stage);
  const preview = new Preview(stage, (about, sides) => {
    picking.drop();
    results.value.surface?.dispose();
    results.set({ surface: null });
    const { up, camera } = state.value;
    stage.fit(sides, up ?? upOf(about), up !== null);
    if (camera) stage.view = camera;
  });
  const overlay = new Overlay(stage, picking);
  const access = new Access(() => void begin());
  const connection = new Connection(() => access.probe, notices);
  const conductor = new Conductor(access, state, results, notices, connection);
  const meshes = new Meshes(access, results, notices, connection);
  const entrance = fileEntrance((dropped) => void take(dropped));
  const theme = new ThemeSwitch((clay) => view.setClay(clay));

  const actions: Actions = {
    open: entrance.open,
    chooseMesh: (id) => void choose(id),
    readAgain: (reading) => void readAgain(reading),
    renameMesh: () => renameMesh(),
    deleteMesh: () => deleteMesh(),
    fit,
    turn,
    compare: () => conductor.compare(),
    clear: () => state.set({ sources: [], via: [], target: null, arrow: null, tool: 'source', show: 'distance' }),
    placeTyped,
    sourcesFrom: (file) => void sourcesFrom(file),
    keep: () => {
      const { path } = results.value;
      const { sources, via, target, method, pointsPerEdge, refine, measures } = state.value;
      if (!path?.reachable || !target || !sources.length || measures.length >= MOST_MEASURES) return;
      // Several sources: the one that the path begins at.
      const { face, bary } = path.from;
      const from = sources.find((spot) => spot.face === face) ?? { face: face!, bary: bary as unknown as [number, number, number] };
      const measure = { from, via, to: target, method, pointsPerEdge, refine };
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
  const steps = new History(state);
  const parts = { state, results, actions };
  const importing = importPart(parts);

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
        { keys: 'Ctrl Z', does: 'Undo; with Shift redo' },
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
        { keys: 'E', does: 'Edges of the mesh', run: () => state.set({ edges: !state.value.edges }) },
        { keys: 'L', does: 'Distances along the path', run: () => state.set({ ticks: !state.value.ticks }) },
        { keys: 'R', does: 'Pull the path straight', run: () => state.set({ refine: !state.value.refine }) },
        { keys: 'M', does: 'Next method', run: nextMethod },
        { keys: 'O', does: 'Open a file', run: entrance.open },
        { keys: 'Escape', does: 'Stop what is under way', run: () => conductor.stop() },
        { keys: '?', does: 'This sheet', run: () => showKeys() },
      ],
    },
  ]);

  const follow = (listener: () => void) => {
    steps.listen(listener);
    listener();
  };
  addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.target instanceof HTMLInputElement && event.target.type === 'text') return;
    if (document.querySelector('dialog[open]')) return; // what is undone would be behind it
    const key = event.key.toLowerCase();
    if (key !== 'z' && key !== 'y') return;
    event.preventDefault();
    if (key === 'y' || event.shiftKey) steps.redo();
    else steps.undo();
  });

  let ready = false;
  const panel = new Panel(
    [
      { label: 'Undo', icon: 'M7 5L3.5 8.5L7 12M4 8.5h7.5a4 4 0 0 1 0 8H9', run: () => steps.undo(), follow: (enable) => follow(() => enable(steps.canUndo)) },
      { label: 'Redo', icon: 'M13 5l3.5 3.5L13 12M16 8.5H8.5a4 4 0 0 0 0 8H11', run: () => steps.redo(), follow: (enable) => follow(() => enable(steps.canRedo)) },
      { label: 'Dark or light', icon: 'M10 3a7 7 0 1 0 7 7a5.5 5.5 0 0 1-7-7', run: () => theme.toggle() },
      { label: 'Keys and gestures', icon: 'M7.5 7.5a2.5 2.5 0 1 1 3.6 2.2c-.8.4-1.1.9-1.1 1.8M10 14.5v.5', run: () => showKeys() },
    ],
    [
      meshPart(parts, importing.root), pointsPart(parts), placePart(parts), resultPart(parts), profilePart(parts), arrowPart(parts),
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
  const scaleBar = new ScaleBar(stage);
  gestures.use({
    stage,
    overlay,
    picking,
    state,
    surface: () => results.value.surface,
    dragging: (handle) => {
      view.still = handle?.kind === 'source';
      steps.hold(handle !== null);
      conductor.hold(handle !== null);
    },
    hovering: (at) => {
      if (results.value.profiled && results.value.path) results.set({ along: at && overlay.alongAt(at.x, at.y) });
    },
    full: () => notices.trouble({ title: 'No more sources', advice: 'The server takes a thousand.', detail: '' }),
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
    if (now.surface !== before.surface) scaleBar.take(now.surface);
    if (now.surface !== before.surface || now.meshes !== before.meshes) entitle();
  });
  connection.onBack(() => void begin());
  // Nobody waits any more: the tab is closed, another page comes, or the network is gone.
  addEventListener('pagehide', () => {
    conductor.abandon();
    meshes.abandon();
  });
  addEventListener('pageshow', ({ persisted }) => { if (persisted) void begin(); });
  addEventListener('offline', () => conductor.abandon());
  stage.onTurned(() => state.set({ camera: stage.view }));
  addEventListener('hashchange', () => void followLink(stateIn(location.hash)));

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
    if (matchMedia('(pointer: coarse)').matches && navigator.canShare?.({ url: link })) {
      return navigator.share({ title: document.title, url: link }).catch(() => undefined); // changed their mind
    }
    try {
      await navigator.clipboard.writeText(link);
      notices.hint('The link is on the clipboard');
    } catch {
      notices.hint('The link is in the address bar'); // clipboards need https or localhost
    }
    setTimeout(() => notices.hint(hintOf(state.value)), 2500);
  }

  /** Whether the axis that is up was chosen for this mesh. */
  let turned = false;

  function fit(): void {
    const { surface } = results.value;
    if (!surface) return;
    const box = surface.geometry.boundingBox ?? (surface.geometry.computeBoundingBox(), surface.geometry.boundingBox!);
    // Points stay as they are seen; only a fresh mesh that is flat is looked straight at.
    stage.fit(box.getSize(new Vector3()), state.value.up ?? upOf(surface.about), turned);
    state.set({ camera: null });
  }

  /** Another axis up, as its reader chooses. */
  function turn(axis: Axis): void {
    const about = results.value.surface?.about;
    if (!about) return;
    rememberUp(about, axis);
    turned = true;
    state.set({ up: axis });
    fit();
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
    turn(axes[(now + 1) % axes.length]!);
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

  /** Places what was typed as the tool says; whether it could. */
  async function placeTyped(text: string): Promise<boolean> {
    const { surface } = results.value;
    const points = pointsInLine(text);
    if (!surface || !points) {
      if (surface && text.trim()) {
        notices.trouble({ title: 'This is no point', advice: 'Type the number of a vertex, or a place as p:x,y,z.', detail: text.slice(0, 200) });
      }
      return false;
    }
    const spots = await locate(points, surface);
    if (!spots) return false;
    const wrong = spots.indexOf(null);
    if (wrong >= 0) {
      notices.trouble({ title: 'No such vertex', advice: `Vertices of this mesh are numbered from 0 to ${countText(surface.about.vertices - 1)}.`, detail: pointText(points[wrong]!) });
      return false;
    }
    const { tool } = state.value;
    const [first, ...rest] = spots as Spot[];
    if (!rest.length || !['source', 'add'].includes(tool)) gestures.place(tool, first!);
    else addSources(tool === 'add' ? [...state.value.sources, first!, ...rest] : [first!, ...rest]);
    return true;
  }

  /** Where points are on the surface, and a notice where they are far from it; null where it could not be asked. */
  async function locate(points: readonly Typed[], surface: Surface): Promise<(Spot | null)[] | null> {
    try {
      const { spots, far } = await spotsOf(points, surface, access.client);
      if (results.value.surface !== surface) return null; // another mesh was chosen meanwhile
      if (far) {
        notices.remark({
          title: 'Far from the surface',
          advice: 'Points were moved to the nearest place on the mesh. Check their unit and their axes.',
          detail: `${far.of > 1 ? `${countText(far.count)} of ${countText(far.of)} points, up to ` : ''}${lengthText(far.farthest)} away`,
        });
      }
      return spots;
    } catch (error) {
      if (!connection.explains(error)) notices.trouble(troubleOf(error), access.remedy(error));
      return null;
    }
  }

  function addSources(sources: readonly Spot[]): void {
    if (sources.length > MOST_SOURCES) notices.trouble({ title: 'No more sources', advice: `The server takes a thousand; the first of ${countText(sources.length)} were taken.`, detail: '' });
    state.set({ sources: sources.slice(0, MOST_SOURCES), tool: state.value.target ? state.value.tool : 'target' });
  }

  async function sourcesFrom(file: File): Promise<void> {
    const { surface } = results.value;
    if (!surface) return;
    const large = tooLarge(file);
    if (large) return notices.trouble(large);
    const { points, strange } = pointsInFile(await file.text(), MOST_SOURCES + 1);
    const told = (detail: string) =>
      notices.trouble({ title: 'No sources in this file', advice: 'It should have a vertex number, or x y z, on each line.', detail: `${file.name}${detail}` });
    if (!points.length || strange !== null) return told(strange === null ? '' : `: ${strange}`);
    const spots = await locate(points, surface);
    if (!spots) return;
    const missing = spots.indexOf(null);
    if (missing >= 0) return told(`: there is no ${pointText(points[missing]!)}`);
    addSources(spots as Spot[]);
  }

  /** All that was dropped goes up; the first of it is shown. */
  async function take(dropped: readonly Dropped[]): Promise<void> {
    notices.clearTroubles();
    const reading = importing.reading();
    const failures = new Failures(notices);
    let shown = false;
    for (const each of dropped) {
      const id = await meshes.upload(each, reading, undefined, failures.add);
      if (!id || shown) continue;
      shown = true;
      void choose(id); // the others do not wait for it
      failures.tell(); // another mesh takes away what was said
    }
  }

  async function readAgain(reading: Reading): Promise<void> {
    const { surface } = results.value;
    if (!surface) return;
    notices.clearTroubles();
    const id = await meshes.readAgain(surface.id, reading);
    if (id) await choose(id);
  }

  function renameMesh(): void {
    const about = results.value.surface?.about;
    if (!about) return;
    ask({
      title: 'Rename this mesh',
      text: 'Everybody who uses this server sees the name.',
      input: { label: 'Name; none brings back the one inside the file', properties: { value: about.name ?? '', name: 'mesh-name' }, fault: nameFault },
      yes: 'Rename',
      run: (typed) => void meshes.rename(about.id, typed),
    });
  }

  function deleteMesh(): void {
    const about = results.value.surface?.about;
    if (!about) return;
    ask({
      title: `Delete ${meshName(about)}?`,
      text: 'The server forgets the mesh and its file, for everybody. Links to it lead nowhere then.',
      yes: 'Delete',
      grave: true,
      run: () => void meshes.delete(about.id).then((gone) => { if (gone) leave(about.id); }),
    });
  }

  /** What is shown is not there any more: another mesh, or none. */
  function leave(id: string): void {
    if (state.value.mesh !== id) return;
    const { first } = meshes;
    if (first) return void choose(first);
    state.set({ ...WITHOUT_POINTS, mesh: null, up: null, camera: null });
    results.value.surface?.dispose();
    results.set({ surface: null });
    document.body.dataset['state'] = 'empty';
  }

  /** A whole state, from a link. */
  async function followLink(wanted: State): Promise<void> {
    if (linkOf(wanted) === linkOf(state.value)) return;
    const other = wanted.mesh !== state.value.mesh;
    state.set(wanted);
    if (other) await show();
    else {
      turned = wanted.up !== null;
      look(wanted.camera);
    }
  }

  /** Loads the state's mesh and looks at it as the state says. */
  async function show(): Promise<void> {
    const { mesh, camera } = state.value;
    if (!mesh) return;
    document.body.dataset['state'] = 'loading';
    const present = results.value.surface;
    if (present?.id === mesh) dropForeignPoints(present);
    else if (!(await meshes.load(mesh, dropForeignPoints, (about, part) => preview.show(about, part)))) {
      if (state.value.mesh !== mesh) return; // another one is on its way
      preview.end();
      document.body.dataset['state'] = 'failed';
      return;
    }
    preview.end();
    const surface = results.value.surface!;
    turned = state.value.up !== null;
    // What is not in the file goes into the link, so that others see the same.
    if (!turned && !saysUp(surface.about)) state.set({ up: upOf(surface.about) });
    look(camera);
    const drawn = nextPicture();
    try {
      if (!(await picking.take(surface))) return; // another one is on its way
    } catch (error) {
      document.body.dataset['state'] = 'failed';
      const reload = { label: 'Reload', run: () => location.reload() };
      return notices.trouble({ title: 'Points cannot be placed on the mesh', advice: 'A part of this page did not come, maybe since the server has a newer one: reload this page.', detail: String(error) }, reload);
    }
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

  function entitle(): void {
    const { surface } = results.value;
    document.title = surface ? `${meshName(surface.about)} · geodesicd` : 'geodesicd';
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
      const first = ({ name }: { name: string }) => Number(name !== START.method);
      results.set({ methods: [...methods].sort((a, b) => first(a) - first(b)) });
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
