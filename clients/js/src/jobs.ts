/**
 * Long work apart from its connection: a request is made a job, watched until it ends, and
 * its reply fetched and forgotten. An abort cancels the job.
 */
import type { Job } from './contract.js';
import { GeodesicError, NetworkError } from './errors.js';
import { eventsOf } from './event_stream.js';
import { jsonOf } from './replies.js';
import { sleep } from './retry.js';
import { reading, type Call, type Reply, type Sender, type Transport } from './transport.js';

export interface JobOptions {
  /**
   * Told of the job whenever something changes: `state`, and `progress` from 0 to 1. After an
   * abort once more, `cancelled`, unless the server could not be told of it.
   */
  onProgress?: ((job: Job) => void) | undefined;
  /** Cancels the job. */
  signal?: AbortSignal | undefined;
}

const BETWEEN_LOOKS = 300; // milliseconds, where the stream of events was lost
const ENDED = new Set(['done', 'failed', 'cancelled']);

/**
 * The reply to `call`, computed as a job. Throws what the plain call would throw, and
 * GeodesicError `job_cancelled` where somebody else cancelled it.
 */
export async function exchangeAsJob(
  transport: Transport,
  call: Call,
  options: JobOptions,
  sender?: Sender,
): Promise<Reply> {
  const { signal } = options;
  const headers = { ...call.headers, Prefer: 'respond-async' };
  signal?.throwIfAborted();
  // Sent twice it would be two jobs. `call` has the signal itself where it is long to send;
  // a query is not aborted under way, or nobody would know the job's id, to cancel it.
  const asked: Call = { ...call, headers, idempotent: false };
  const accepted = await transport.exchange(asked, sender);
  if (accepted.status !== 202) return accepted; // out of the browser's cache, say
  const job = jsonOf<Job>(accepted);
  // Whoever cancels means it; a result that is kept a while longer harms nobody.
  const forget = () =>
    transport
      .exchange({ method: 'DELETE', path: pathOf(job), retry: signal?.aborted ?? false })
      .then(() => true, (error) => error instanceof GeodesicError); // whether the server knows
  try {
    signal?.throwIfAborted();
    await watch(transport, job, options);
    // A result does not change, be it 503: nothing but the connection is worth a second try.
    const result: Call = { method: 'GET', path: `${pathOf(job)}/result`, signal };
    return await asItWas(transport, result);
  } finally {
    const forgotten = forget();
    if (signal?.aborted && (await forgotten)) options.onProgress?.({ ...job, state: 'cancelled' });
  }
}

function pathOf(job: Job): string {
  return `/v1/jobs/${job.id}`;
}

/** The result, tried again over lost connections only. */
async function asItWas(transport: Transport, call: Call): Promise<Reply> {
  for (let lost = 0; ; ++lost) {
    try {
      return await transport.exchange({ ...call, retry: false });
    } catch (error) {
      if (!(error instanceof NetworkError) || lost >= 3) throw error;
      await sleep(BETWEEN_LOOKS, call.signal);
    }
  }
}

/** Resolves when the job has ended. Asks again where the stream of events breaks. */
async function watch(transport: Transport, begun: Job, options: JobOptions): Promise<void> {
  let job = begun;
  const see = (next: Job) => {
    job = next;
    options.onProgress?.(job);
  };
  see(job);
  while (!ENDED.has(job.state)) {
    try {
      await follow(transport, job, options.signal, see);
    } catch (error) {
      options.signal?.throwIfAborted();
      const passing = error instanceof NetworkError || (error as GeodesicError).status === 503;
      if (!passing) throw error;
    }
    if (ENDED.has(job.state)) return;
    await sleep(BETWEEN_LOOKS, options.signal);
    const look: Call = { method: 'GET', path: pathOf(job), signal: options.signal };
    see(jsonOf<Job>(await transport.exchange(look)));
  }
}

async function follow(
  transport: Transport,
  job: Job,
  signal: AbortSignal | undefined,
  see: (job: Job) => void,
): Promise<void> {
  const call: Call = {
    method: 'GET',
    path: `${pathOf(job)}/events`,
    headers: { Accept: 'text/event-stream' },
    signal,
  };
  const response = await transport.open(call);
  if (!response.body) return;
  const events = eventsOf(response.body);
  for (;;) {
    // Only the stream's own failures are the network's; what `see` throws is its caller's.
    const next = await reading(call, transport.url(call.path), () => events.next());
    if (next.done) return;
    see(JSON.parse(next.value.data) as Job);
    if (next.value.id === 'end') {
      await events.return(undefined);
      return;
    }
  }
}
