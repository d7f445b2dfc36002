/**
 * The two errors of this client: what the server refused, and a server that was not
 * reached. An abort is neither; its reason is passed on as it is.
 */
import type { ErrorCode, Problem } from './contract.js';
import { hintOfError } from './hints.js';

/**
 * A reply of status 400 or above. `code` is from the contract's closed set, or
 * `unrecognised` where the reply was not geodesicd's, such as a proxy's page.
 */
export class GeodesicError extends Error {
  override readonly name = 'GeodesicError';
  readonly status: number;
  readonly code: ErrorCode | 'unrecognised';
  /** The same for every error of this code. */
  readonly title: string;
  /** One sentence for a person. */
  readonly detail: string;
  /** The offending parameter or header, such as `from[2]`. */
  readonly parameter: string | undefined;
  /** The bound that was exceeded. */
  readonly limit: number | undefined;
  /** By what it was exceeded. */
  readonly actual: number | undefined;
  /** The request's id in the server's log. */
  readonly requestId: string | undefined;
  /** Seconds after which to try again, where the server says so. */
  readonly retryAfter: number | undefined;
  /** Host and port of who was asked. */
  readonly server: string | undefined;
  /** What to do next, where the server's own sentence does not say it. */
  readonly hint: string | undefined;

  constructor(status: number, problem: Partial<Problem>, headers?: Headers, url?: string) {
    super();
    const code = problem.code ?? 'unrecognised';
    const detail = problem.detail ?? `the reply of status ${status} is no problem document`;
    this.status = status;
    this.code = code;
    this.title = problem.title ?? `Status ${status}`;
    this.detail = detail;
    this.parameter = problem.parameter;
    this.limit = problem.limit;
    this.actual = problem.actual;
    this.requestId = problem.request_id ?? headers?.get('X-Request-Id') ?? undefined;
    this.retryAfter = headers ? secondsToWait(headers) : undefined;
    this.server = url === undefined ? undefined : hostIn(url);
    this.hint = hintOfError(status, code, detail, problem.limit);
    this.message = this.#sentence();
  }

  /** For people: everything that helps to find out what was wrong, and where. */
  #sentence(): string {
    const notes = [
      ['parameter', this.parameter],
      ['limit', this.limit],
      ['actual', this.actual],
      ['request', this.requestId],
      ['server', this.server],
    ].flatMap(([name, value]) => (value === undefined ? [] : [`${name} ${value}`]));
    const told = `${this.code}: ${this.detail}`.replace(/\.+$/, '');
    const where = notes.length ? ` (${notes.join(', ')})` : '';
    const next = this.hint === undefined ? '' : `. ${this.hint}${this.hint.endsWith('?') ? '' : '.'}`;
    return told + where + next;
  }

  /** The same error under another parameter's name, for questions that are asked in pieces. */
  of(parameter: string): GeodesicError {
    const problem = { ...this, request_id: this.requestId, parameter } as Partial<Problem>;
    const { retryAfter } = this;
    const url = this.server && `http://${this.server}`;
    return Object.assign(new GeodesicError(this.status, problem, undefined, url), { retryAfter });
  }
}

/** No reply: no connection, or one that was lost. `cause` is what the platform said. */
export class NetworkError extends Error {
  override readonly name = 'NetworkError';
  /** What was asked for. */
  readonly url: string;

  constructor(url: string, cause: unknown) {
    super(`no reply from ${url}: ${reasonOf(cause)}${hintOf(url)}`, { cause });
    this.url = url;
  }
}

/** A browser does not tell its page that CORS was the reason: the flags are named on suspicion. */
function hintOf(url: string): string {
  const own = globalThis.location?.origin;
  if (own === undefined || url === '' || new URL(url, own).origin === own) return '';
  return (
    `. Does it run, and is --cors-origins set for this origin, ${own}? ` +
    'To upload and delete, --cors-write-origins has to name it too'
  );
}

/** The error that a reply of status 400 or above stands for; `url` is what was asked. */
export function errorOf(
  status: number,
  headers: Headers,
  body: ArrayBuffer,
  url: string,
): GeodesicError {
  return new GeodesicError(status, problemIn(headers, body), headers, url);
}

function hostIn(url: string): string | undefined {
  try {
    return new URL(url).host;
  } catch {
    return undefined; // one that an error was made with by hand
  }
}

function problemIn(headers: Headers, body: ArrayBuffer): Partial<Problem> {
  if (!headers.get('Content-Type')?.startsWith('application/problem+json')) return {};
  try {
    return JSON.parse(new TextDecoder().decode(body)) as Problem;
  } catch {
    return {}; // a reply cut short
  }
}

/** `Retry-After`, which is seconds or a date (RFC 9110). */
function secondsToWait(headers: Headers): number | undefined {
  const text = headers.get('Retry-After');
  if (text === null) return undefined;
  const seconds = /^\s*\d+\s*$/.test(text) ? Number(text) : (Date.parse(text) - Date.now()) / 1000;
  return Number.isFinite(seconds) ? Math.max(0, seconds) : undefined;
}

/** Node says "fetch failed" and keeps the reason in the cause of the cause. */
function reasonOf(cause: unknown): string {
  if (!(cause instanceof Error)) return String(cause);
  return cause.cause instanceof Error && cause.cause.message ? cause.cause.message : cause.message;
}
