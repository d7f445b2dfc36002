/**
 * The types that are written by hand name exactly what the contract names. Checked by the
 * compiler alone: a parameter that the contract gains or loses stops the build of the tests.
 */
import type * as client from 'geodesicd-client';
import type { Schemas } from 'geodesicd-client';

type Same<A, B> = [A] extends [B] ? ([B] extends [A] ? true : false) : false;
/** In options, in the choice of a method, or in drawings instead. */
type Elsewhere = 'format' | 'deadline_ms' | 'attribute' | 'label_attribute' | keyof client.Drawing;
type Names<Request> = Exclude<keyof Request, Elsewhere>;

export const checks: {
  distance: Same<keyof client.DistancesAtQuery, Names<Schemas['DistanceRequest']>>;
  path: Same<keyof client.PathQuery, Names<Schemas['PathRequest']>>;
  table: Same<
    keyof client.TableRowsQuery | 'precision' | 'stream' | 'sparse' | 'rows',
    Names<Schemas['TableRequest']>
  >;
  isolines: Same<keyof client.IsolinesQuery, Names<Schemas['IsolinesRequest']>>;
  nearest: Same<keyof client.NearestQuery, Names<Schemas['NearestRequest']>>;
  trace: Same<keyof client.TraceQuery, Names<Schemas['TraceRequest']>>;
  loop: Same<keyof client.LoopQuery, Names<Schemas['LoopRequest']>>;
  logmap: Same<keyof client.LogmapQuery | 'precision', Names<Schemas['LogmapRequest']>>;
  measure: Same<keyof client.MeasureQuery, Names<Schemas['MeasureRequest']>>;
  extent: Same<keyof client.ExtentQuery, Names<Schemas['ExtentRequest']>>;
  voronoi: Same<keyof client.VoronoiQuery | 'part', Names<Schemas['VoronoiRequest']>>;
  samples: Same<keyof client.SamplesQuery, Names<Schemas['SamplesRequest']>>;
  drawing: Same<keyof client.Drawing, Extract<keyof Schemas['DistanceRequest'], keyof client.Drawing>>;
  formats: Same<client.ArrayFormat | 'json' | 'frame' | 'glb' | 'png', Schemas['Format']>;
  fields: Same<Schemas['Format'] | 'annotated', Schemas['FieldFormat']>;
} = {
  distance: true,
  path: true,
  table: true,
  isolines: true,
  nearest: true,
  trace: true,
  loop: true,
  logmap: true,
  measure: true,
  extent: true,
  voronoi: true,
  samples: true,
  drawing: true,
  formats: true,
  fields: true,
};
