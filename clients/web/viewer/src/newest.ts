/**
 * One request at a time, and the newest question next: what a pointer asks sixty times a
 * second is answered as often as the server can, and no queue ever grows.
 */
export class Newest<Question> {
  #running: AbortController | null = null;
  #next: { question: Question } | null = null;
  readonly #run: (question: Question, signal: AbortSignal) => Promise<void>;

  /** `run` handles its own errors. */
  constructor(run: (question: Question, signal: AbortSignal) => Promise<void>) {
    this.#run = run;
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
      this.#running = new AbortController();
      await this.#run(question, this.#running.signal);
    }
    this.#running = null;
  }
}
