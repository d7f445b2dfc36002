/**
 * The page: makes its parts and ties them together. The state says what is wanted, the
 * conductor gets it from the server, stage, overlay, legend and panel show it, and the
 * link carries it away and back.
 */
import { Vector3 } from 'three';
import type { Reading } from 'geodesicd-client';
import { Access } from './access.ts';
import { AddressBar } from './address_bar.ts';
import { hasNewPoints } from './arrivals.ts';
import { brushPart } from './brush_part.ts';
import { cellsPart } from './cells_part.ts';
import { Conductor } from './conductor.ts';
import { Connection } from './connection.ts';
import { discPart } from './disc_part.ts';
import { closed, roundPoint } from './drawing.ts';
import { element } from './element.ts';
import { fileEntrance, type Dropped } from './entrance.ts';
import { exported } from './exports.ts';
import { exportPart } from './export_part.ts';
import { Failures } from './failures.ts';
import { FirstQuestions } from './first_questions.ts';
import { Gestures } from './gestures.ts';
import { History } from './history.ts';
import { Legend, roomForLegend } from './legend.ts';
import { linkOf, meshNameIn, stateIn, strangeIn, tooMuchPainted } from './link.ts';
import { pointsOn } from './link_points.ts';
import { loopPart } from './loop_part.ts';
import { lookPart } from './look_part.ts';
import { measureList } from './measure_list.ts';
import { importPart } from './import_part.ts';
import { Meshes } from './meshes.ts';
import { askName, askToDelete } from './mesh_dialogs.ts';
import { meshName } from './mesh_names.ts';
import { meshPart } from './mesh_part.ts';
import { troubleOf } from './messages.ts';
import { methodPart } from './method_part.ts';
import { Notices } from './notices.ts';
import { Overlay } from './overlay.ts';
import { PaintedView } from './painted_view.ts';
import { Painter } from './painter.ts';
import { pageKeys } from './page_keys.ts';
import { Panel } from './panel.ts';
import type { Actions } from './parts.ts';
import { Picking } from './picking.ts';
import { Preview } from './preview.ts';
import { placePart } from './place_part.ts';
import { arrowPart, hintOf, pointsPart } from './points_part.ts';
import { profilePart } from './profile_part.ts';
import { Remembered } from './remembered.ts';
import { resultPart } from './result_part.ts';
import { NOTHING, surfaceOf, type Results } from './results.ts';
import { NoWebGL, Stage } from './stage.ts';
import { MOST_LINES, MOST_MEASURES, Store, WITHOUT_POINTS, type Axis, type State } from './state.ts';
import { ScaleBar } from './scale_bar.ts';
import type { Surface } from './surface.ts';
import { SurfaceView } from './surface_view.ts';
import { ThemeSwitch } from './theme.ts';
import { fullText, LOOP_IS_FULL, TypedPoints } from './typed_points.ts';
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
  const paintedView = new PaintedView(stage);
  const painter = new Painter(stage, picking, state, present, paintedView);
  const preview = new Preview(stage, (about, sides) => {
    picking.drop();
    results.value.surface?.dispose();
    results.set({ surface: null });
    const { up, camera } = state.value;
    stage.fit(sides, up ?? upOf(about), up !== null);
    if (camera) stage.view = camera;
  });
  const overlay = new Overlay(stage, picking);
  const address = new AddressBar(state, () => present() !== null);
  const access = new Access(() => void begin());
  const connection = new Connection(() => access.probe, notices);
  const conductor = new Conductor(access, state, results, notices, connection);
  const meshes = new Meshes(access, results, notices, connection);
  const firstQuestions = new FirstQuestions(access, results, meshes, notices, connection, () => void begin());
  const entrance = fileEntrance((dropped) => void take(dropped));
  const typed = new TypedPoints({ state, results, notices, access, connection, place: (tool, spot) => gestures.place(tool, spot) });
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
    clear: () => state.set({ sources: [], via: [], target: null, arrow: null, loop: null, curves: [], disc: null, tool: 'source', show: 'distance' }),
    closeLoop: () => {
      const { loop } = state.value;
      if (loop) state.set({ loop: closed(loop) });
    },
    roundHere: (across) => {
      const { loop } = state.value;
      const surface = present();
      if (loop && surface) state.set({ loop: roundPoint(loop, across, surface, stage.camera) });
    },
    use: (as) => {
      const { loop, painted, curves } = state.value;
      if (!loop) return;
      const line = { points: loop.points, closed: loop.kind === 'through' };
      if ((as === 'wall' ? painted.walls : curves).length >= MOST_LINES) return sayBriefly(`The page takes ${MOST_LINES} of them`);
      state.set(as === 'wall' ? { painted: { ...painted, walls: [...painted.walls, line] }, loop: null } : { curves: [...curves, line], loop: null });
    },
    relax: () => conductor.relax(),
    placeTyped: (text) => typed.place(text),
    sourcesFrom: (file) => void typed.fromFile(file),
    keep: () => {
      const { path, stale } = results.value;
      const { sources, via, target, method, pointsPerEdge, refine, painted, measures } = state.value;
      if (!path?.reachable || stale || !target || !sources.length || state.value.curves.length || state.value.walking || measures.length >= MOST_MEASURES) return;
      // Several sources: the one that the path begins at.
      const { face, bary } = path.from;
      const from = sources.find((spot) => spot.face === face) ?? { face: face!, bary: bary as unknown as [number, number, number] };
      const measure = { from, via, to: target, method, pointsPerEdge, refine, painted };
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
  const remembered = new Remembered();
  const parts = { state, results, actions };
  const importing = importPart(parts);

  const showKeys = pageKeys({
    ...parts, theme: () => theme.toggle(), fold: () => panel.toggle(), nextUp, escape, say: sayBriefly,
  });

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
      meshPart(parts, importing.root), pointsPart(parts), loopPart(parts), brushPart(parts), cellsPart(parts), placePart(parts), resultPart(parts), profilePart(parts), arrowPart(parts), discPart(parts),
      lookPart(parts), methodPart(parts), measureList(parts), exportPart(parts),
    ],
    (right, bottom) => {
      stage.cover({ top: roomForLegend(), right, bottom });
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
    painter,
    state,
    surface: present,
    dragging: (handle) => {
      view.still = handle?.kind === 'source';
      steps.hold(handle !== null);
      conductor.hold(handle !== null);
    },
    hovering: (at) => {
      if (results.value.profiled && results.value.path) results.set({ along: at && overlay.alongAt(at.x, at.y) });
    },
    full: (tool) => notices.remark(tool === 'loop' ? LOOP_IS_FULL : fullText()),
  });
  ready = true;
  gestures.centre();

  state.listen((now, before) => {
    if ((['sources', 'via', 'target', 'arrow', 'loop', 'curves'] as const).some((name) => now[name] !== before[name])) notices.settle('points');
    view.follow(now, before, results.value, results.value);
    overlay.follow(now, before, results.value, results.value);
    if (now.painted !== before.painted) paintedView.show(present(), now.painted);
    legend.follow(now, results.value);
    notices.hint(hintOf(now));
    if (now.mesh !== before.mesh && results.value.surface?.id === before.mesh) left = before;
    if (!returning && (now.measures !== before.measures || now.mesh !== before.mesh)) notices.clearTroubles();
    firstQuestions.follow(now, before, () => conductor.askAgain());
    address.write();
  });
  results.listen((now, before) => {
    view.follow(state.value, state.value, now, before);
    overlay.follow(state.value, state.value, now, before);
    if (now.surface !== before.surface) paintedView.show(present(), state.value.painted);
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
  // Not the address as it is now: the page may have written its own link since.
  addEventListener('hashchange', ({ newURL }) => void followLink(new URL(newURL).hash));

  async function copyLink(): Promise<void> {
    state.set({ camera: stage.view });
    const link = new URL(`#${linkOf(state.value)}`, location.href).href;
    address.writeNow();
    if (tooMuchPainted(state.value)) return sayBriefly('More is painted than a link can hold: this one is without it');
    if (matchMedia('(pointer: coarse)').matches && navigator.canShare?.({ url: link })) {
      return navigator.share({ title: document.title, url: link }).catch(() => undefined); // changed their mind
    }
    try {
      await navigator.clipboard.writeText(link);
      sayBriefly('The link is on the clipboard');
    } catch {
      sayBriefly('The link is in the address bar'); // clipboards need https or localhost
    }
  }

  /** In the hint's place, for as long as one reads it. */
  function sayBriefly(text: string): void {
    notices.hint(text);
    setTimeout(() => notices.hint(hintOf(state.value)), 2500);
  }

  function escape(): void {
    if (conductor.busy || notices.working) conductor.stop();
    else notices.clearTroubles();
  }

  /** Whether the axis that is up was chosen for this mesh. */
  let turned = false;

  function fit(): void {
    const { surface } = results.value;
    if (!surface) return;
    // Points stay as they are seen; only a fresh mesh that is flat is looked straight at.
    stage.fit(surface.geometry.boundingBox!.getSize(new Vector3()), state.value.up ?? upOf(surface.about), turned);
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

  /** Another mesh, with the points that it had when it was left. */
  async function choose(id: string): Promise<void> {
    if (!id || (id === state.value.mesh && results.value.surface?.id === id)) return;
    address.writeNow(); // as it is left
    remembered.keep(state.value);
    state.set({ ...remembered.of(id), mesh: id, up: null, camera: null });
    await show();
  }

  /** The mesh that is chosen, if it is the one that is drawn: only on that points are placed. */
  function present(): Surface | null {
    return surfaceOf(state.value, results.value);
  }

  /** What was seen when another mesh was chosen. */
  let left: State | null = null;
  let returning = false;

  /** The mesh that was chosen does not come: the one that is still drawn is chosen again, with its points. */
  function goBack(): void {
    const { surface } = results.value;
    if (!surface) return;
    address.forget();
    returning = true; // why it does not come stays to be read
    state.set(left?.mesh === surface.id ? left : { ...WITHOUT_POINTS, mesh: surface.id, up: null, camera: null });
    returning = false;
    conductor.askAgain();
    document.body.dataset['state'] = 'ready';
  }

  /** All that was dropped goes up; the first of it is shown. */
  async function take(dropped: readonly Dropped[]): Promise<void> {
    notices.clearTroubles();
    const reading = importing.reading();
    if (!reading) {
      notices.trouble({ title: 'An import option cannot be read', advice: 'Mend or empty the marked field, then open the file again.', detail: '' });
      return;
    }
    const before = state.value;
    const failures = new Failures(notices);
    let shown = false;
    for (const each of dropped) {
      const id = await meshes.upload(each, reading, undefined, failures.add);
      if (!id || shown) continue;
      shown = true;
      void showArrived(id, before); // the others do not wait for it
      failures.tell(); // another mesh takes away what was said
    }
  }

  async function readAgain(reading: Reading): Promise<void> {
    const { surface } = results.value;
    if (!surface) return;
    notices.clearTroubles();
    const before = state.value;
    const id = await meshes.readAgain(surface.id, reading);
    if (id) await showArrived(id, before);
  }

  /** A mesh that has come, unless it would take away points that were placed while it came. */
  async function showArrived(id: string, before: State): Promise<void> {
    if (id === state.value.mesh || !hasNewPoints(state.value, before)) return choose(id);
    const about = results.value.meshes.find((mesh) => mesh.id === id);
    notices.remark(
      { title: `${about ? meshName(about) : 'The mesh'} is here`, advice: 'It is in the list of meshes: your points stay on the one that you see.', detail: '' },
      { label: 'Show it', run: () => void choose(id) },
    );
  }

  function renameMesh(): void {
    const about = results.value.surface?.about;
    if (about) askName(about, (typed) => void meshes.rename(about.id, typed));
  }

  function deleteMesh(): void {
    const about = results.value.surface?.about;
    if (about) askToDelete(about, () => void meshes.delete(about.id).then((gone) => { if (gone) leave(about.id); }));
  }

  /** What is shown is not there any more: another mesh, or none. */
  function leave(id: string): void {
    if (state.value.mesh !== id) return;
    const { first } = meshes;
    if (first) void choose(first);
    else {
      state.set({ ...WITHOUT_POINTS, mesh: null, up: null, camera: null });
      results.value.surface?.dispose();
      results.set({ surface: null });
      document.body.dataset['state'] = 'empty';
    }
    address.forget();
  }

  /** Points of the link that cannot be read, until they are told. */
  let strange = strangeIn(location.hash);

  let followed = 0; // links so far

  /** A whole state, from a link. */
  async function followLink(fragment: string): Promise<void> {
    const [turn, before] = [++followed, state.value.mesh];
    const name = meshNameIn(fragment);
    address.arrived(stateIn(fragment).mesh);
    // A link that says no mesh is about the present one: without one nothing could be asked.
    const mesh = name === null ? stateIn(fragment).mesh ?? state.value.mesh : await meshes.called(name);
    if (turn !== followed || state.value.mesh !== before) return; // its reader has gone on meanwhile
    if (name !== null && !mesh) return address.write(); // all stays as it is
    let wanted = { ...stateIn(fragment), mesh };
    strange = strangeIn(fragment);
    const other = wanted.mesh !== state.value.mesh;
    const surface = other ? null : present();
    const { points, lost } = surface ? pointsOn(surface, wanted) : { points: {}, lost: [] };
    wanted = { ...wanted, ...points };
    const same = linkOf(wanted) === linkOf(state.value);
    if (other) remembered.keep(state.value);
    if (same) address.write();
    else state.set(wanted);
    if (other) return show();
    tellLost(lost);
    if (same) return;
    turned = wanted.up !== null;
    look(wanted.camera);
  }

  /** Loads the state's mesh and looks at it as the state says. */
  async function show(): Promise<void> {
    const { mesh, camera } = state.value;
    if (!mesh) return;
    document.body.dataset['state'] = 'loading';
    const settle = (surface: Surface) => {
      const { points, lost } = pointsOn(surface, state.value);
      steps.quietly(() => state.set(points)); // to undo it would bring them back
      tellLost(lost);
    };
    const drawn = present();
    if (drawn) {
      meshes.stay();
      settle(drawn);
      conductor.askAgain();
    } else {
      const loaded = await meshes.load(mesh, settle, (about, part) => preview.show(about, part));
      if (loaded === 'left' || state.value.mesh !== mesh) return; // another one is on its way
      if (loaded !== 'there') {
        preview.end();
        document.body.dataset['state'] = 'failed';
        if (loaded === 'failed') goBack();
        return;
      }
    }
    preview.end();
    address.writeNow();
    const surface = results.value.surface!;
    turned = state.value.up !== null;
    // What is not in the file goes into the link, so that others see the same.
    if (!turned && !saysUp(surface.about)) state.set({ up: upOf(surface.about) });
    look(camera);
    const picture = nextPicture();
    try {
      if (!(await picking.take(surface))) return; // another one is on its way
    } catch (error) {
      document.body.dataset['state'] = 'failed';
      const reload = { label: 'Reload', run: () => { address.writeNow(); location.reload(); } };
      return notices.trouble({ title: 'Points cannot be placed on the mesh', advice: 'A part of this page did not come, maybe since the server has a newer one: reload this page.', detail: String(error) }, reload);
    }
    await picture;
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

  /** A link may have been written by hand: what cannot be read of its points, or is not on the mesh, is told. */
  function tellLost(lost: readonly string[]): void {
    const left = [...strange, ...lost];
    strange = [];
    if (!left.length) return;
    address.write();
    notices.trouble({
      title: 'Some points of this link were left out',
      advice: 'They are not on the mesh, or no points. The link may belong to another mesh.',
      detail: left.join(' · ').slice(0, 200),
      about: 'points',
    });
  }

  /** The first questions, and the same again when the server has come back. */
  async function begin(): Promise<void> {
    const { mesh } = state.value;
    const asked = mesh && results.value.surface?.id !== mesh ? show() : null;
    await firstQuestions.ask(() => conductor.askAgain());
    await asked;
    const name = state.value.mesh ? null : meshNameIn(location.hash);
    if (name !== null && results.value.meshes.length) {
      const mesh = await meshes.called(name);
      if (state.value.mesh) return; // chosen meanwhile
      if (!mesh) return void (document.body.dataset['state'] = 'failed');
      state.set({ mesh });
      await show();
    }
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
