/**
 * The page: makes its parts and ties them together. The state says what is wanted, the
 * conductor gets it from the server, stage, overlay, legend and panel show it, and the
 * link carries it away and back.
 */
import { Access } from './access.ts';
import { AddressBar } from './address_bar.ts';
import { brushPart } from './brush_part.ts';
import { cellsPart } from './cells_part.ts';
import { Conductor } from './conductor.ts';
import { Connection } from './connection.ts';
import { discPart } from './disc_part.ts';
import { closed, roundPoint, usedAs } from './drawing.ts';
import { element } from './element.ts';
import { fileEntrance } from './entrance.ts';
import { exportPart } from './export_part.ts';
import { exported } from './exports.ts';
import { FirstQuestions } from './first_questions.ts';
import { Gestures } from './gestures.ts';
import { headButtons } from './head_buttons.ts';
import { History } from './history.ts';
import { importPart } from './import_part.ts';
import { Incoming } from './incoming.ts';
import { Legend, roomForLegend } from './legend.ts';
import { stateIn } from './link.ts';
import { lookPart } from './look_part.ts';
import { loopPart } from './loop_part.ts';
import { measureList } from './measure_list.ts';
import { keptOf } from './measures.ts';
import { askName, askToDelete } from './mesh_dialogs.ts';
import { meshName } from './mesh_names.ts';
import { meshPart } from './mesh_part.ts';
import { Meshes } from './meshes.ts';
import { fullText, LOOP_IS_FULL, troubleOf, VIA_IS_FULL } from './messages.ts';
import { methodPart } from './method_part.ts';
import { Notices } from './notices.ts';
import { Overlay } from './overlay.ts';
import { pageKeys } from './page_keys.ts';
import { PaintedView } from './painted_view.ts';
import { Painter } from './painter.ts';
import { Panel } from './panel.ts';
import type { Actions } from './parts.ts';
import { Picking } from './picking.ts';
import { placePart } from './place_part.ts';
import { arrowPart, hintOf, pointsPart } from './points_part.ts';
import { Preview } from './preview.ts';
import { profilePart } from './profile_part.ts';
import { resultPart } from './result_part.ts';
import { NOTHING, surfaceOf, type Results } from './results.ts';
import { ScaleBar } from './scale_bar.ts';
import { shareLink } from './share_link.ts';
import { Showing } from './showing.ts';
import { NoWebGL, Stage } from './stage.ts';
import { CLEARED, differ, MOST_LINES, POINTS, Store, type State } from './state.ts';
import { SurfaceView } from './surface_view.ts';
import { ThemeSwitch } from './theme.ts';
import { TypedPoints } from './typed_points.ts';
import { Viewpoint } from './viewpoint.ts';

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
  // Only on the mesh that is chosen, and drawn, points are placed.
  const present = () => surfaceOf(state.value, results.value);
  const painter = new Painter(stage, picking, state, present, paintedView);
  const viewpoint = new Viewpoint(stage, state, results);
  const preview = new Preview(stage, (about, sides) => {
    picking.drop();
    results.value.surface?.dispose();
    results.set({ surface: null });
    viewpoint.foresee(about, sides);
  });
  const overlay = new Overlay(stage, picking);
  const address = new AddressBar(state, () => present() !== null);
  const access = new Access(() => void showing.begin());
  const connection = new Connection(() => access.probe, notices);
  const conductor = new Conductor(access, state, results, notices, connection);
  const meshes = new Meshes(access, results, notices, connection);
  const firstQuestions = new FirstQuestions(access, results, meshes, notices, connection, () => void showing.begin());
  const entrance = fileEntrance((dropped) => void incoming.take(dropped, importing.reading()));
  const typed = new TypedPoints({ state, results, notices, access, connection, place: (tool, spot) => gestures.place(tool, spot) });
  const steps = new History(state);
  const showing = new Showing({
    state, results, notices, address, conductor, meshes, firstQuestions, steps, stage, picking, preview, viewpoint,
  });
  const incoming = new Incoming(state, results, meshes, notices, (id) => showing.choose(id));
  const theme = new ThemeSwitch((clay) => view.setClay(clay));

  const actions: Actions = {
    open: entrance.open,
    chooseMesh: (id) => void showing.choose(id),
    readAgain: (reading) => void incoming.readAgain(reading),
    renameMesh: () => {
      const about = results.value.surface?.about;
      if (about) askName(about, (typed) => void meshes.rename(about.id, typed));
    },
    deleteMesh: () => {
      const about = results.value.surface?.about;
      if (about) askToDelete(about, () => void meshes.delete(about.id).then((gone) => { if (gone) showing.leave(about.id); }));
    },
    fit: () => viewpoint.fit(),
    turn: (axis) => viewpoint.turn(axis),
    compare: () => conductor.compare(),
    clear: () => state.set(CLEARED),
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
      const { loop } = state.value;
      if (!loop) return;
      const used = usedAs(as, loop, state.value);
      if (used) state.set(used);
      else sayBriefly(`The page takes ${MOST_LINES} of them`);
    },
    relax: () => conductor.relax(),
    placeTyped: (text) => typed.place(text),
    sourcesFrom: (file) => void typed.fromFile(file),
    keep: () => {
      const kept = keptOf(state.value, results.value);
      if (!kept) return;
      conductor.keep(kept.measure, kept.path);
      state.set({ measures: [...state.value.measures, kept.measure] });
    },
    copyLink: () => {
      state.set({ camera: stage.view });
      void shareLink(state.value, address, sayBriefly);
    },
    exported: (kind) => {
      exported(kind, { access, stage, overlay, state: state.value, results: results.value }).catch((error: unknown) => {
        if (!connection.explains(error)) notices.trouble(troubleOf(error), access.remedy(error));
      });
    },
  };
  const parts = { state, results, actions };
  const importing = importPart(parts);

  const showKeys = pageKeys({
    ...parts, steps, theme: () => theme.toggle(), fold: () => panel.toggle(), nextUp: () => viewpoint.nextUp(), escape, say: sayBriefly,
  });

  let ready = false;
  const panel = new Panel(
    headButtons(steps, () => theme.toggle(), () => showKeys()),
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
    full: (tool) => notices.remark(tool === 'loop' ? LOOP_IS_FULL : tool === 'via' ? VIA_IS_FULL : fullText()),
  });
  ready = true;
  gestures.centre();

  state.listen((now, before) => {
    if (differ(now, before, ...POINTS)) notices.settle('points');
    view.follow(now, before, results.value, results.value);
    overlay.follow(now, before, results.value, results.value);
    if (now.painted !== before.painted) paintedView.show(present(), now.painted);
    // A listener before this one may have changed it again.
    legend.follow(state.value, results.value);
    notices.hint(hintOf(state.value));
    showing.follow(now, before);
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
  connection.onBack(() => void showing.begin());
  // Nobody waits any more: the tab is closed, another page comes, or the network is gone.
  addEventListener('pagehide', () => {
    conductor.abandon();
    meshes.abandon();
  });
  addEventListener('pageshow', ({ persisted }) => { if (persisted) void showing.begin(); });
  addEventListener('offline', () => conductor.abandon());
  stage.onTurned(() => state.set({ camera: stage.view }));
  // Not the address as it is now: the page may have written its own link since.
  addEventListener('hashchange', ({ newURL }) => void showing.followLink(new URL(newURL).hash));

  /** In the hint's place, for as long as one reads it. */
  function sayBriefly(text: string): void {
    notices.hint(text);
    setTimeout(() => notices.hint(hintOf(state.value)), 2500);
  }

  function escape(): void {
    if (conductor.busy || notices.working) conductor.stop();
    else notices.clearTroubles();
  }

  function entitle(): void {
    const { surface } = results.value;
    document.title = surface ? `${meshName(surface.about)} · geodesicd` : 'geodesicd';
  }

  document.body.append(element('div', { className: 'drop-zone', aria: { hidden: 'true' } }, 'Drop to upload'));
  notices.hint(hintOf(state.value));
  void showing.begin();
}
