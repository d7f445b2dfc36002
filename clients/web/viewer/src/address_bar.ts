/**
 * The address bar: a link to what is seen. To another mesh is a step of the browser's history, so that
 * Back leads to the mesh before; all else changes the link of the present step.
 */
import { linkOf } from './link.ts';
import type { State, Store } from './state.ts';

export class AddressBar {
  #timer = 0;
  /** The mesh of the history's present step; null where the next link takes that step's place. */
  #mesh: string | null;

  /** `drawn`: whether the state's mesh is seen. One that is still on its way may never come, so it is no step yet. */
  constructor(
    private readonly state: Store<State>,
    private readonly drawn: () => boolean,
  ) {
    this.#mesh = state.value.mesh;
    // Whoever comes back to this page finds it as it was left.
    addEventListener('pagehide', () => this.#timer && this.writeNow());
  }

  /** Soon: browsers allow a hundred links in half a minute. Until then the page's body has `data-link="late"`. */
  write(): void {
    clearTimeout(this.#timer);
    this.#timer = window.setTimeout(() => this.writeNow(), 250);
    document.body.dataset.link = 'late';
  }

  writeNow(): void {
    this.#rest();
    const { mesh } = this.state.value;
    const step = this.#mesh !== null && mesh !== this.#mesh;
    if (step && !this.drawn()) return;
    const link = `#${linkOf(this.state.value)}`;
    if (step) history.pushState(null, '', link);
    else history.replaceState(null, '', link);
    this.#mesh = mesh;
  }

  /** The browser has gone to a link by itself: that of this mesh. */
  arrived(mesh: string | null): void {
    this.#rest();
    this.#mesh = mesh;
  }

  /** The mesh of the present step is not to be had: what is seen instead takes its place, and Back leads further. */
  forget(): void {
    this.#mesh = null;
  }

  /** Nothing is to be written. */
  #rest(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
    delete document.body.dataset.link;
  }
}
