/**
 * Which mesh is seen: the first one, the one that is chosen, or a link's, with the points that belong to
 * it. Of one that does not come the page goes back to what is still drawn. `body[data-state]` says how far it is.
 */
import type { AddressBar } from './address_bar.ts';
import type { Conductor } from './conductor.ts';
import type { FirstQuestions } from './first_questions.ts';
import type { History } from './history.ts';
import { linkOf, meshNameIn, stateIn } from './link.ts';
import { pointsOn } from './link_points.ts';
import { LostPoints } from './lost_points.ts';
import type { Meshes } from './meshes.ts';
import type { Notices } from './notices.ts';
import type { Picking } from './picking.ts';
import type { Preview } from './preview.ts';
import { Remembered } from './remembered.ts';
import { surfaceOf, type Results } from './results.ts';
import type { Stage } from './stage.ts';
import { WITHOUT_POINTS, type State, type Store } from './state.ts';
import type { Surface } from './surface.ts';
import { saysUp, upOf } from './upright.ts';
import type { Viewpoint } from './viewpoint.ts';

export interface ShowingOptions {
  readonly state: Store<State>;
  readonly results: Store<Results>;
  readonly notices: Notices;
  readonly address: AddressBar;
  readonly conductor: Conductor;
  readonly meshes: Meshes;
  readonly firstQuestions: FirstQuestions;
  readonly steps: History;
  readonly stage: Stage;
  readonly picking: Picking;
  readonly preview: Preview;
  readonly viewpoint: Viewpoint;
}

function tellState(now: 'loading' | 'ready' | 'empty' | 'failed'): void {
  document.body.dataset['state'] = now;
}

export class Showing {
  readonly #remembered = new Remembered();
  readonly #lost: LostPoints;
  /** What was seen when another mesh was chosen. */
  #left: State | null = null;
  #returning = false;
  /** Links so far. */
  #followed = 0;

  constructor(private readonly options: ShowingOptions) {
    this.#lost = new LostPoints(location.hash, options.address, options.notices);
  }

  /** The mesh that is chosen, if it is the one that is drawn. */
  get #present(): Surface | null {
    return surfaceOf(this.options.state.value, this.options.results.value);
  }

  /** The first questions, and the same again when the server has come back. */
  async begin(): Promise<void> {
    const { state, results, meshes, conductor, firstQuestions } = this.options;
    const { mesh } = state.value;
    const asked = mesh && results.value.surface?.id !== mesh ? this.#show() : null;
    await firstQuestions.ask(() => conductor.askAgain());
    await asked;
    const name = state.value.mesh ? null : meshNameIn(location.hash);
    if (name !== null && results.value.meshes.length) {
      const called = await meshes.called(name);
      if (state.value.mesh) return; // chosen meanwhile
      if (!called) return tellState('failed');
      state.set({ mesh: called });
      await this.#show();
    }
    const { first } = meshes;
    if (!state.value.mesh && first) {
      state.set({ mesh: first });
      await this.#show();
    }
    if (!state.value.mesh) tellState('empty');
  }

  /** To be told of each change. */
  follow(now: State, before: State): void {
    const { results, notices } = this.options;
    if (now.mesh !== before.mesh && results.value.surface?.id === before.mesh) this.#left = before;
    if (!this.#returning && (now.measures !== before.measures || now.mesh !== before.mesh)) notices.clearTroubles();
  }

  /** Another mesh, with the points that it had when it was left. */
  async choose(id: string): Promise<void> {
    const { state, results, address } = this.options;
    if (!id || (id === state.value.mesh && results.value.surface?.id === id)) return;
    address.writeNow(); // as it is left
    this.#remembered.keep(state.value);
    state.set({ ...this.#remembered.of(id), mesh: id, up: null, camera: null });
    await this.#show();
  }

  /** A mesh is not there any more: if it is the one that is shown, another takes its place, or none. */
  leave(id: string): void {
    const { state, results, address, meshes } = this.options;
    if (state.value.mesh !== id) return;
    const { first } = meshes;
    if (first) void this.choose(first);
    else {
      state.set({ ...WITHOUT_POINTS, mesh: null, up: null, camera: null });
      results.value.surface?.dispose();
      results.set({ surface: null });
      tellState('empty');
    }
    address.forget();
  }

  /** A whole state, from a link. */
  async followLink(fragment: string): Promise<void> {
    const { state, address, meshes, viewpoint } = this.options;
    const [turn, before] = [++this.#followed, state.value.mesh];
    const name = meshNameIn(fragment);
    address.arrived(stateIn(fragment).mesh);
    // A link that says no mesh is about the present one: without one nothing could be asked.
    const mesh = name === null ? stateIn(fragment).mesh ?? state.value.mesh : await meshes.called(name);
    if (turn !== this.#followed || state.value.mesh !== before) return; // its reader has gone on meanwhile
    if (name !== null && !mesh) return address.write(); // all stays as it is
    let wanted = { ...stateIn(fragment), mesh };
    this.#lost.read(fragment);
    const other = wanted.mesh !== state.value.mesh;
    const surface = other ? null : this.#present;
    const { points, lost } = surface ? pointsOn(surface, wanted) : { points: {}, lost: [] };
    wanted = { ...wanted, ...points };
    const same = linkOf(wanted) === linkOf(state.value);
    if (other) this.#remembered.keep(state.value);
    if (same) address.write();
    else state.set(wanted);
    if (other) return this.#show();
    this.#lost.tell(lost);
    if (!same) viewpoint.look(wanted);
  }

  /** Loads the state's mesh and looks at it as the state says. */
  async #show(): Promise<void> {
    const { state, results, address, conductor, meshes, steps, picking, preview, viewpoint, notices } = this.options;
    const { mesh, camera } = state.value;
    if (!mesh) return;
    tellState('loading');
    const settle = (surface: Surface) => {
      const { points, lost } = pointsOn(surface, state.value);
      steps.quietly(() => state.set(points)); // to undo it would bring them back
      this.#lost.tell(lost);
    };
    const drawn = this.#present;
    if (drawn) {
      meshes.stay();
      settle(drawn);
      conductor.askAgain();
    } else {
      const loaded = await meshes.load(mesh, settle, (about, part) => preview.show(about, part));
      if (loaded === 'left' || state.value.mesh !== mesh) return; // another one is on its way
      if (loaded !== 'there') {
        preview.end();
        tellState('failed');
        if (loaded === 'failed') this.#goBack();
        return;
      }
    }
    preview.end();
    address.writeNow();
    const surface = results.value.surface!;
    const { up } = state.value;
    // What is not in the file goes into the link, so that others see the same.
    if (up === null && !saysUp(surface.about)) state.set({ up: upOf(surface.about) });
    viewpoint.look({ up, camera });
    const picture = this.#nextPicture();
    try {
      if (!(await picking.take(surface))) return; // another one is on its way
    } catch (error) {
      tellState('failed');
      const reload = { label: 'Reload', run: () => { address.writeNow(); location.reload(); } };
      return notices.trouble({ title: 'Points cannot be placed on the mesh', advice: 'A part of this page did not come, maybe since the server has a newer one: reload this page.', detail: String(error) }, reload);
    }
    await picture;
    tellState('ready');
  }

  /** The mesh that was chosen does not come: the one that is still drawn is chosen again, with its points. */
  #goBack(): void {
    const { state, results, address, conductor } = this.options;
    const { surface } = results.value;
    if (!surface) return;
    address.forget();
    this.#returning = true; // why it does not come stays to be read
    state.set(this.#left?.mesh === surface.id ? this.#left : { ...WITHOUT_POINTS, mesh: surface.id, up: null, camera: null });
    this.#returning = false;
    conductor.askAgain();
    tellState('ready');
  }

  /** Resolves when what is on the stage now has been drawn: two frames on. */
  #nextPicture(): Promise<void> {
    this.options.stage.wake();
    return new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => {
      performance.mark('geodesicd:picture'); // to be measured from outside
      resolve();
    })));
  }
}
