/** Many queries in one request: NDJSON there, NDJSON back, answers as they arrive. */
import type { Problem, QueryName, Schemas } from './contract.js';
import { GeodesicError } from './errors.js';
import { linesOf } from './lines.js';
import { meshPath, parametersInJson } from './plans.js';
import type * as queries from './queries.js';
import type { CallOptions } from './queries.js';
import { warningsIn } from './replies.js';
import { reading, type Call, type Transport } from './transport.js';

interface Taken {
  distance: queries.DistanceQuery & Partial<queries.DistancesAtQuery>;
  path: queries.PathQuery;
  table: queries.TableQuery & { precision?: number };
  isolines: queries.IsolinesQuery;
  samples: queries.SamplesQuery;
  measure: queries.MeasureQuery;
  extent: queries.ExtentQuery;
  voronoi: queries.VoronoiQuery;
  trace: queries.TraceQuery;
  loop: queries.LoopQuery;
  logmap: queries.LogmapQuery & { precision?: number };
  nearest: queries.NearestQuery;
}

interface Given {
  distance: Schemas['DistanceReply'];
  path: Schemas['PathReply'];
  table: Schemas['TableReply'];
  isolines: Schemas['IsolinesReply'];
  samples: Schemas['SamplesReply'];
  measure: Schemas['MeasureReply'];
  extent: Schemas['ExtentReply'];
  voronoi: Schemas['VoronoiReply'];
  trace: Schemas['TraceReply'];
  loop: Schemas['LoopReply'];
  logmap: Schemas['LogmapReply'];
  nearest: Schemas['NearestReply'];
}

/** One query of a batch; `id` comes back with its answer. */
export type BatchQuery<Name extends QueryName = QueryName> = {
  [N in Name]: { query: N; id?: string | number; deadline_ms?: number } & Taken[N];
}[Name];

/** One answer: the query's reply, or the error that it would have thrown on its own. */
export type BatchAnswer<Name extends QueryName = QueryName> =
  | { id: string | number | undefined; status: number; ok: true; reply: Given[Name] & Pick<queries.Told, 'warnings'> }
  | { id: string | number | undefined; status: number; ok: false; error: GeodesicError };

/** Answers in the queries' order. Whoever stops early ends the request. */
export async function* batch<Name extends QueryName>(
  transport: Transport,
  id: string,
  asked: Iterable<BatchQuery<Name>>,
  options: CallOptions,
): AsyncGenerator<BatchAnswer<Name>, void, undefined> {
  const lines = Array.from(asked, (query) => JSON.stringify(parametersInJson(query)));
  const call: Call = {
    method: 'POST',
    path: meshPath(id, 'batch'),
    headers: { 'Content-Type': 'application/x-ndjson' },
    body: lines.map((line) => `${line}\n`).join(''),
    idempotent: true, // until the first answer; what breaks later is thrown
    signal: options.signal,
  };
  const response = await transport.open(call);
  if (!response.body) return;
  const answers = linesOf(response.body);
  const url = transport.url(call.path);
  try {
    for (;;) {
      const next = await reading(call, url, () => answers.next());
      if (next.done) return;
      if (next.value !== '') yield answerOf<Name>(next.value, url);
    }
  } finally {
    await answers.return(undefined);
  }
}

function answerOf<Name extends QueryName>(line: string, url: string): BatchAnswer<Name> {
  const { id, status, reply, problem } = JSON.parse(line) as Schemas['BatchReply'];
  return problem
    ? { id, status, ok: false, error: new GeodesicError(status, problem as Problem, undefined, url) }
    : { id, status, ok: true, reply: { ...(reply as unknown as Given[Name]), warnings: warningsIn(reply) } };
}
