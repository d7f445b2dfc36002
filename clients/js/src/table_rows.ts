/**
 * Tables of thousands: rows as the server computes them, asked for again from where a connection
 * broke, and tables of which only what is near is kept.
 */
import { GeodesicError, NetworkError } from './errors.js';
import { queryCall } from './plans.js';
import type { Point } from './points.js';
import type {
  QueryOptions,
  SparseTable,
  SparseTableQuery,
  TableQuery,
  TableRow,
} from './queries.js';
import { sparseTableOf } from './replies.js';
import { sleep } from './retry.js';
import type { Transport } from './transport.js';

/** Tries in a row that bring nothing, before an interruption is an error. */
const MOST_TRIES = 4;
const FIRST_PAUSE = 250; // milliseconds, doubled each time

/**
 * The rows of a table of any size that the server takes as a stream, each once, in order.
 * `deadlineMs` is for the whole. Whoever stops early ends the request.
 */
export async function* tableRows(
  transport: Transport,
  id: string,
  query: TableQuery,
  options: QueryOptions,
): AsyncGenerator<TableRow, void, undefined> {
  const from = (Array.isArray(query.from) ? query.from : [query.from]) as readonly Point[];
  const to = query.to ?? query.from;
  const columns = Array.isArray(to) ? to.length : 1;
  const end = options.deadlineMs === undefined ? undefined : Date.now() + options.deadlineMs;
  let row = 0;
  for (let tried = 0; row < from.length; ) {
    const before = row;
    const deadlineMs = end === undefined ? undefined : Math.max(1, Math.ceil(end - Date.now()));
    const asked = { ...query, stream: true, format: 'f64', rows: `${row}-` };
    const call = queryCall(id, 'table', asked, { ...options, deadlineMs });
    try {
      const response = await transport.open(call);
      for await (const distances of rowsOf(response.body!, columns, transport.url(call.path))) {
        yield { row, distances };
        ++row;
      }
    } catch (error) {
      options.signal?.throwIfAborted();
      if (!(error instanceof NetworkError)) throw error;
      tried = row > before ? 0 : tried + 1;
      if (end !== undefined && Date.now() >= end) {
        const detail = 'the time that deadlineMs allowed is over';
        throw new GeodesicError(504, { code: 'deadline', detail });
      }
      if (tried >= MOST_TRIES) throw error;
      await sleep(FIRST_PAUSE * 2 ** tried, options.signal);
    }
  }
}

/** A body's rows of so many distances. Throws NetworkError where it breaks off. */
async function* rowsOf(
  body: ReadableStream<Uint8Array>,
  columns: number,
  url: string,
): AsyncGenerator<Float64Array, void, undefined> {
  const reader = body.getReader();
  let bytes = new Uint8Array(8 * columns);
  let filled = 0;
  let ended = false;
  try {
    for (;;) {
      const { done, value } = await reader.read().catch((cause: unknown) => {
        ended = true;
        throw new NetworkError(url, cause);
      });
      ended = done;
      if (done) break;
      for (let used = 0; used < value.length; ) {
        const some = value.subarray(used, used + bytes.length - filled);
        bytes.set(some, filled);
        used += some.length;
        filled += some.length;
        if (filled < bytes.length) continue;
        yield new Float64Array(bytes.buffer); // a buffer of its own
        bytes = new Uint8Array(8 * columns);
        filled = 0;
      }
    }
    if (filled > 0) throw new NetworkError(url, new Error('the last row is not whole'));
  } finally {
    if (!ended) await reader.cancel().catch(() => undefined);
  }
}

/** What of a table is within `max`. */
export async function sparseTable(
  transport: Transport,
  id: string,
  query: SparseTableQuery,
  options: QueryOptions,
): Promise<SparseTable> {
  const asked = { ...query, sparse: true, format: 'frame' };
  return sparseTableOf(await transport.exchange(queryCall(id, 'table', asked, options)));
}
