/** One server for the tests of one file, with the plane uploaded, and waiting for what is to come. */
import { after } from 'node:test';
import { GeodesicClient } from 'geodesicd-client';
import { sample, Server } from './server.js';

export interface Fixture {
  server: Server;
  client: GeodesicClient;
  /** The plane's id: 100 by 100 vertices, one unit apart. */
  plane: string;
}

/** Starts the server; it ends with the tests of the file that asks. */
export async function fixture(flags: string[] = []): Promise<Fixture> {
  const server = await Server.start(flags);
  after(() => server.stop());
  const client = new GeodesicClient(server.url);
  const { id } = await client.upload(sample('plane.glb'));
  return { server, client, plane: id };
}

/** Polls until it is so; generous, since machines are loaded. */
export async function until(condition: () => boolean | Promise<boolean>, what: string): Promise<void> {
  for (let tries = 0; tries < 6000; ++tries) {
    if (await condition()) return;
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  throw new Error(`waited in vain: ${what}`);
}

/** A table that takes minutes, for a job or a request to be ended early. */
export const SLOW = {
  from: Array.from({ length: 400 }, (_, row) => ({ vertex: 80 * row })),
  method: 'chen_han' as const,
};

/** `fetch`, and each request that goes through it as `METHOD path`. */
export function watchedFetch(seen: string[]): typeof fetch {
  return (input, init) => {
    const url = new URL(String(input));
    seen.push(`${init?.method ?? 'GET'} ${url.pathname}${url.search}`);
    return fetch(input, init);
  };
}
