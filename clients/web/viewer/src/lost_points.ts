/** What a link says of points that cannot be read, or that the mesh does not have: somebody may have written it by hand. */
import type { AddressBar } from './address_bar.ts';
import { strangeIn } from './link.ts';
import type { Notices } from './notices.ts';

export class LostPoints {
  /** Of the last link what cannot be read, until it is told. */
  #strange: readonly string[];

  constructor(
    fragment: string,
    private readonly address: AddressBar,
    private readonly notices: Notices,
  ) {
    this.#strange = strangeIn(fragment);
  }

  /** Another link has come. */
  read(fragment: string): void {
    this.#strange = strangeIn(fragment);
  }

  /** Tells them, and those that are not on the mesh. */
  tell(notThere: readonly string[]): void {
    const lost = [...this.#strange, ...notThere];
    this.#strange = [];
    if (!lost.length) return;
    this.address.write();
    this.notices.trouble({
      title: 'Some points of this link were left out',
      advice: 'They are not on the mesh, or no points. The link may belong to another mesh.',
      detail: lost.join(' · ').slice(0, 200),
      about: 'points',
    });
  }
}
