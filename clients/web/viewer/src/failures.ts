/** What failed of several pieces of work: each is told at once, and those of one kind together. */
import type { Trouble } from './messages.ts';
import type { Notices } from './notices.ts';

/** Details that are told; of the others their number. */
const TOLD = 5;

type Told = Parameters<Notices['trouble']>;

export class Failures {
  readonly #all = new Map<string, { told: Told; details: string[] }>();

  constructor(private readonly notices: Notices) {}

  readonly add = (...told: Told): void => {
    const { title, detail } = told[0];
    const kind = this.#all.get(title);
    if (kind) kind.details.push(detail);
    else this.#all.set(title, { told, details: [detail] });
    this.tell(title);
  };

  /** Once more, where the page has taken them away since: all, or those of one kind. */
  tell(only?: string): void {
    for (const [title, { told: [trouble, action], details }] of this.#all) {
      if (only !== undefined && only !== title) continue;
      const more = details.length > TOLD ? [`and ${details.length - TOLD} more`] : [];
      const said: Trouble = { ...trouble, detail: [...details.slice(0, TOLD), ...more].filter(Boolean).join(' · ') };
      this.notices.trouble(said, action);
    }
  }
}
