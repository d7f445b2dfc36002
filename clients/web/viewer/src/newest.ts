/**
 * One request at a time, and the newest question next: what a pointer asks sixty times a
 * second is answered as often as the server can, and no queue ever grows.
 */
export class Newest<Question> {
  #running: AbortController | null = null;
  #next: { question: Question } | null = null;
  #present = '';
  readonly #run: (question: Question, signal: AbortSignal) => Promise<void>;
  readonly #keyOf: (question: Question) => string;

  /** `run` handles its own errors. Two questions of one key, other than none, are the same. */
  constructor(run: (question: Question, signal: AbortSignal) => Promise<void>, keyOf: (question: Question) => string = () => '') {
    this.#run = run;
    this.#keyOf = keyOf;
  }

  get busy(): boolean {
    return this.#running !== null;
  }

  /** Whether a newer question waits for the one that runs. */
  get waiting(): boolean {
    return this.#next !== null;
  }

  /** `interrupt`: what runs is not wanted any more, and is aborted. */
  ask(question: Question, interrupt = false): void {
    const key = this.#keyOf(question);
    if (key && key === this.#present && this.#running && !this.#running.signal.aborted) {
      this.#next = null; // it is on its way already
      return;
    }
    this.#next = { question };
    if (interrupt) this.#running?.abort();
    if (!this.#running) void this.#work();
  }

  cancel(): void {
    this.#next = null;
    this.#running?.abort();
  }

  async #work(): Promise<void> {
    while (this.#next) {
      const { question } = this.#next;
      this.#next = null;
      this.#present = this.#keyOf(question);
      this.#running = new AbortController();
      await this.#run(question, this.#running.signal);
    }
    this.#running = null;
  }
}
