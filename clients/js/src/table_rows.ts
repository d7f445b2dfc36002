/**
 * Tables of thousands: rows as the server computes them, asked for again from where a connection
 * broke, and tables of which only what is near is kept.
 */
import { chunksOf } from './chunks.js';
import { NetworkError } from './errors.js';
import { queryCall } from './plans.js';
import { listOf } from './points.js';
import type {
  Estimated,
  QueryOptions,
  SparseTable,
  SparseTableQuery,
  TableRow,
  TableRowsQuery,
} from './queries.js';
import { sparseTableOf } from './replies.js';
import { msUntil, sleep, waitAfter } from './retry.js';
import type { Transport } from './transport.js';

/**
 * The rows of a table of any size that the server takes as a stream, each once, in order.
 * `deadlineMs` is for the whole. Whoever stops early ends the request. Where a connection breaks,
 * the rest is asked for as often in a row as the client's `retries` say, until a row comes.
 */
export async function* tableRows(
  transport: Transport,
  id: string,
  query: TableRowsQuery,
  options: QueryOptions,
): AsyncGenerator<TableRow, void, undefined> {
  const from = listOf(query.from);
  const columns = query.to === undefined ? from.length : listOf(query.to).length;
  const end = options.deadlineMs === undefined ? undefined : Date.now() + options.deadlineMs;
  const left = () => (end === undefined ? undefined : msUntil(end));
  let { deadlineMs } = options;
  let row = 0;
  for (let tried = 0; row < from.length; ) {
    const before = row;
    const asked = { ...query, stream: true, format: 'f64', rows: `${row}-` };
    const call = queryCall(id, 'table', asked, { ...options, deadlineMs });
    const url = transport.url(call.path);
    try {
      const response = await transport.open(call);
      if (!hasRows(response, from.length - row, columns)) {
        throw new NetworkError(url, new Error('the reply is no table of that size'));
      }
      const told = response.headers.get('Geo-Estimated');
      const estimated = told === null ? {} : { estimated: JSON.parse(told) as Estimated };
      for await (const distances of rowsOf(response.body!, columns, url)) {
        yield { row, distances, ...estimated };
        ++row;
      }
      // Somebody on the way may end a reply early as if it were whole.
      if (row < from.length) throw new NetworkError(url, new Error('rows are missing'));
    } catch (error) {
      options.signal?.throwIfAborted();
      if (!(error instanceof NetworkError)) throw error;
      if (row > before) tried = 0;
      left();
      if (tried >= transport.rules.retries) throw error;
      await sleep(waitAfter(tried++, transport.rules), options.signal);
      deadlineMs = left();
    }
  }
}

/** Whether a reply has these distances, and is not the page of somebody on the way. */
function hasRows(response: Response, rows: number, columns: number): boolean {
  const { status, headers } = response;
  return (
    status === 200 &&
    headers.get('Geo-Dtype') === '<f8' &&
    headers.get('Geo-Shape') === `${rows},${columns}`
  );
}

/** A body's rows of so many distances. Throws NetworkError where it breaks off. */
async function* rowsOf(
  body: ReadableStream<Uint8Array>,
  columns: number,
  url: string,
): AsyncGenerator<Float64Array, void, undefined> {
  let bytes = new Uint8Array(8 * columns);
  let filled = 0;
  try {
    for await (const chunk of chunksOf(body)) {
      for (let used = 0; used < chunk.length; ) {
        const some = chunk.subarray(used, used + bytes.length - filled);
        bytes.set(some, filled);
        used += some.length;
        filled += some.length;
        if (filled < bytes.length) continue;
        yield new Float64Array(bytes.buffer); // a buffer of its own
        bytes = new Uint8Array(8 * columns);
        filled = 0;
      }
    }
  } catch (cause) {
    throw new NetworkError(url, cause);
  }
  if (filled > 0) throw new NetworkError(url, new Error('the last row is not whole'));
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
