/**
 * What the page remembers: in the browser's storage where that lets it, else for as long as
 * the page lives. Storage may be full, or forbidden, and then its very name throws.
 */
export class Kept {
  /** What the storage did not take; undefined where it has the value. */
  #here: string | null | undefined;

  constructor(
    private readonly storage: 'localStorage' | 'sessionStorage',
    private readonly name: string,
  ) {}

  get value(): string | null {
    if (this.#here !== undefined) return this.#here;
    try {
      return window[this.storage].getItem(this.name);
    } catch {
      return null;
    }
  }

  set value(value: string | null) {
    try {
      if (value === null) window[this.storage].removeItem(this.name);
      else window[this.storage].setItem(this.name, value);
      this.#here = undefined;
    } catch {
      this.#here = value;
    }
  }
}
