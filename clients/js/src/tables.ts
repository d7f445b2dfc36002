/**
 * Tables of any size: what the server's limits do not let into one request is asked for in
 * blocks, one after the other, and joined here.
 */
import type { Status } from './contract.js';
import { GeodesicError } from './errors.js';
import { planOf } from './plans.js';
import { listOf } from './points.js';
import type { QueryOptions, Table, TableQuery, Timing } from './queries.js';
import { jsonOf } from './replies.js';
import { msUntil } from './retry.js';
import { cuts, fits, sizesOf, totalOf, type Row, type Run, type Size } from './sizes.js';
import type { Transport } from './transport.js';

/** What servers take that do not say otherwise: up to here none is asked for its limits. */
const LIMITS = {
  max_sources: 1000,
  max_points: 100_000,
  max_curve_points: 1000,
  max_table_entries: 1_000_000,
  max_json_bytes: 8 << 20,
};
type Limits = typeof LIMITS;

interface Block {
  rows: Run;
  columns: Run;
}

/** The distances of a table, however many requests it takes; `deadlineMs` is for the whole. */
export async function table(
  transport: Transport,
  id: string,
  query: TableQuery,
  options: QueryOptions,
): Promise<Table> {
  const ask = async (some: TableQuery, more: QueryOptions): Promise<Table> => {
    const plan = planOf(id, { query: 'table', ...some }, more);
    return plan.read(await transport.exchange(plan.call));
  };
  const rows = listOf(query.from);
  const columns: readonly Row[] = query.to === undefined ? rows : listOf(query.to);
  if (!rows.length || !columns.length || isOne(rows, columns, LIMITS)) return ask(query, options);
  const limits = await toldLimits(transport, options);
  if (isOne(rows, columns, limits)) return ask(query, options);

  const end = options.deadlineMs === undefined ? undefined : Date.now() + options.deadlineMs;
  const distances = new Float64Array(rows.length * columns.length);
  const answers: [Block, Table][] = [];
  for (const block of blocks(rows, columns, limits)) {
    const some = { ...query, from: slice(rows, block.rows), to: slice(columns, block.columns) };
    const deadlineMs = end === undefined ? undefined : msUntil(end);
    try {
      const { distances: found, ...answer } = await ask(some, { ...options, deadlineMs });
      const width = block.columns.end - block.columns.begin;
      for (let row = block.rows.begin; row < block.rows.end; ++row) {
        const first = (row - block.rows.begin) * width;
        const place = row * columns.length + block.columns.begin;
        distances.set(found.subarray(first, first + width), place);
      }
      answers.push([block, { ...answer, distances }]);
    } catch (error) {
      throw error instanceof GeodesicError ? told(error, block) : error;
    }
  }
  return joined(answers, distances);
}

/** All but the distances: those of the first block, and what the others add to them. */
function joined(answers: readonly [Block, Table][], distances: Float64Array): Table {
  const timing: Record<string, number> = {};
  for (const [, answer] of answers) {
    for (const [stage, milliseconds] of Object.entries(answer.timing as Required<Timing>)) {
      timing[stage] = (timing[stage] ?? 0) + milliseconds;
    }
  }
  return {
    ...answers[0]![1],
    rows: answers.flatMap(([block, answer]) => (block.columns.begin === 0 ? answer.rows : [])),
    columns: answers.flatMap(([block, answer]) => (block.rows.begin === 0 ? answer.columns : [])),
    distances,
    timing,
    cache: answers.every(([, { cache }]) => cache === 'hit') ? 'hit' : 'miss',
    warnings: [...new Set(answers.flatMap(([, answer]) => answer.warnings))],
  };
}

function slice<T extends Row>(points: readonly T[], { begin, end }: Run): readonly T[] {
  return points.slice(begin, end);
}

async function toldLimits(transport: Transport, { signal }: QueryOptions): Promise<Limits> {
  try {
    const reply = await transport.exchange({ method: 'GET', path: '/v1/status', signal });
    return { ...LIMITS, ...jsonOf<Status>(reply).limits };
  } catch (error) {
    if (error instanceof GeodesicError) return LIMITS; // a token may not allow to ask
    throw error;
  }
}

/** Bytes that the points of a request may take, with room for the rest of it. */
function bodyLimit(limits: Limits): number {
  return (limits.max_json_bytes * 3) / 4;
}

/** Of the rows of one request. */
function mostRows(limits: Limits, bytes: number): Size {
  const most = limits.max_sources;
  return { number: most, bytes, lines: most, curvePoints: limits.max_curve_points };
}

/** Of the columns of one request. A column that is a line takes a field, as a row does. */
function mostColumns(limits: Limits, bytes: number): Size {
  const number = Math.min(limits.max_points, limits.max_table_entries);
  return { number, bytes, lines: limits.max_sources, curvePoints: limits.max_curve_points };
}

/** Whether the whole table may be one request. */
function isOne(rows: readonly Row[], columns: readonly Row[], limits: Limits): boolean {
  const [ofRows, ofColumns] = [totalOf(rows), totalOf(columns)];
  return (
    fits(ofRows, mostRows(limits, Infinity)) &&
    fits(ofColumns, mostColumns(limits, Infinity)) &&
    ofRows.number * ofColumns.number <= limits.max_table_entries &&
    ofRows.bytes + ofColumns.bytes <= bodyLimit(limits)
  );
}

/**
 * Rows and columns of each request. Blocks are as wide as can be, and those of the same rows follow
 * each other: each row costs a field, which the server may still have then.
 */
function* blocks(
  rows: readonly Row[],
  columns: readonly Row[],
  limits: Limits,
): Generator<Block> {
  const room = Math.floor(bodyLimit(limits) / 2);
  const widths = [...cuts(sizesOf(columns), mostColumns(limits, room))];
  const width = Math.max(...widths.map(({ begin, end }) => end - begin));
  const most = mostRows(limits, room);
  const number = Math.min(most.number, Math.max(1, Math.floor(limits.max_table_entries / width)));
  for (const some of cuts(sizesOf(rows), { ...most, number })) {
    for (const others of widths) yield { rows: some, columns: others };
  }
}

/** An error of a block, its `from[2]` as it is called in the whole. */
function told(error: GeodesicError, { rows, columns }: Block): GeodesicError {
  const found = /^(from|to)\[(\d+)\](.*)$/s.exec(error.parameter ?? '');
  if (!found) return error;
  const { begin } = found[1] === 'from' ? rows : columns;
  return error.of(`${found[1]}[${Number(found[2]) + begin}]${found[3]}`);
}
