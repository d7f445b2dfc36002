/**
 * When a call is tried again: where the server says that it has no time now (429, 503),
 * and where the connection failed and to ask twice does no harm. Never after an abort.
 */
import { GeodesicError, NetworkError } from './errors.js';

export interface RetryRules {
  /** How often a call is tried again. */
  retries: number;
  /** The longest single wait, in milliseconds; a `Retry-After` beyond it is not waited for. */
  maxWait: number;
}

const FIRST_WAIT = 250; // milliseconds, doubled each time

/** Runs `attempt` until it succeeds, must not be tried again or has been tried enough. */
export async function withRetries<T>(
  rules: RetryRules,
  idempotent: boolean,
  signal: AbortSignal | undefined,
  attempt: () => Promise<T>,
): Promise<T> {
  for (let tried = 0; ; ++tried) {
    signal?.throwIfAborted();
    try {
      return await attempt();
    } catch (error) {
      signal?.throwIfAborted();
      if (tried >= rules.retries || !mayRetry(error, idempotent)) throw error;
      const wait = waitBefore(error, tried, rules);
      if (wait > rules.maxWait) throw error;
      await sleep(wait, signal);
    }
  }
}

function mayRetry(error: unknown, idempotent: boolean): boolean {
  if (error instanceof NetworkError) return idempotent;
  return error instanceof GeodesicError && (error.status === 429 || error.status === 503);
}

/** Milliseconds to wait after a connection broke for the `tried`th time in a row, from 0. */
export function waitAfter(tried: number, { maxWait }: RetryRules): number {
  // Somewhere in the later half of each wait, so that clients turned away together part.
  return Math.min(FIRST_WAIT * 2 ** tried, maxWait) * (0.5 + Math.random() / 2);
}

function waitBefore(error: unknown, tried: number, rules: RetryRules): number {
  const asked = error instanceof GeodesicError ? (error.retryAfter ?? 0) * 1000 : 0;
  return Math.max(waitAfter(tried, rules), asked);
}

/** Waits; rejects with the signal's reason when it is aborted. */
export function sleep(milliseconds: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const stop = () => {
      clearTimeout(timer);
      reject(signal?.reason);
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener('abort', stop);
      resolve();
    }, milliseconds);
    signal?.addEventListener('abort', stop, { once: true });
  });
}

/** Milliseconds until a time that is a deadline. Throws what the server answers where it is over. */
export function msUntil(end: number): number {
  const left = Math.ceil(end - Date.now());
  if (left > 0) return left;
  const detail = 'the time that deadlineMs allowed is over';
  throw new GeodesicError(504, { code: 'deadline', detail });
}
