/** The shared table of contract cases as it is read; its `about` says what each member means. */
import { readFileSync } from 'node:fs';

export type Arguments = Record<string, unknown>;

export interface ArrayExpected {
  dtype: string;
  shape: number[];
  values: Record<string, number>;
  unreached?: number[];
  max?: number;
}

export interface Expected {
  status: number;
  id?: string | number;
  code?: string;
  parameter?: string | string[];
  limit?: number;
  actual?: number;
  retry_after?: boolean;
  json?: Record<string, unknown>;
  arrays?: Record<string, ArrayExpected>;
  bytes?: {
    begins?: string;
    media_type?: string;
    sha256?: string;
    png?: [number, number];
    at_least?: number;
  };
  headers?: Record<string, string>;
  lines?: Expected[];
}

export interface Step {
  call: string;
  arguments?: Arguments;
  job?: boolean;
  expect: Expected;
  save?: Record<string, { header?: string; json?: string }>;
}

export interface Case extends Partial<Omit<Step, 'save'>> {
  name: string;
  server?: string;
  token?: string | null;
  mesh?: string | { id: string };
  tolerance?: number;
  steps?: Step[];
}

export interface CaseTable {
  servers: Record<string, { flags: string[]; tokens?: Record<string, [token: string, scopes: string]> }>;
  not_here: Record<string, string>;
  file_names: { refused: string; taken: string; rows: [file: string, name: string | null][] };
  meshes: Record<string, { text: string }>;
  cases: Case[];
}

/** The table, which both this client and the Python client run. */
export function readCases(): CaseTable {
  const path = new URL('../../../tests/clients/contract_cases.json', import.meta.url);
  return JSON.parse(readFileSync(path, 'utf8')) as CaseTable;
}
