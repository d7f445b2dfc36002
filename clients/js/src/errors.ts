/**
 * The two errors of this client: what the server refused, and a server that was not
 * reached. An abort is neither; its reason is passed on as it is.
 */
import type { ErrorCode, Problem } from './contract.js';

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

  constructor(status: number, problem: Partial<Problem>, headers?: Headers) {
    const code = problem.code ?? 'unrecognised';
    const detail = problem.detail ?? `the reply of status ${status} is no problem document`;
    const of = problem.parameter === undefined ? '' : ` (${problem.parameter})`;
    super(`${code}${of}: ${detail}`);
    this.status = status;
    this.code = code;
    this.title = problem.title ?? `Status ${status}`;
    this.detail = detail;
    this.parameter = problem.parameter;
    this.limit = problem.limit;
    this.actual = problem.actual;
    this.requestId = problem.request_id ?? headers?.get('X-Request-Id') ?? undefined;
    this.retryAfter = headers ? secondsToWait(headers) : undefined;
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

/** The error that a reply of status 400 or above stands for. */
export function errorOf(status: number, headers: Headers, body: ArrayBuffer): GeodesicError {
  return new GeodesicError(status, problemIn(headers, body), headers);
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
