/**
 * A proxy before a real server that gets in the way as proxies and networks do: it turns
 * requests away, drops connections, cuts replies short. What it lets through is the
 * server's own.
 */
import { once } from 'node:events';
import { createServer, request, type IncomingMessage, type ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';

/** What is done to one request; `pass` after so many bytes of the reply cuts the connection. */
export type Fault =
  | { drop: true }
  | { status: number; headers?: Record<string, string>; body?: string }
  | { cutAfter: number };

export class FaultyProxy {
  /** Faults for the next requests whose path contains `on`, one each, in turn. */
  faults: { on: string; fault: Fault }[] = [];
  /** `METHOD path` of each request that has arrived. */
  readonly seen: string[] = [];
  url = '';
  readonly #server = createServer((from, to) => this.#serve(from, to));
  readonly #target: URL;

  private constructor(target: string) {
    this.#target = new URL(target);
  }

  static async before(target: string): Promise<FaultyProxy> {
    const proxy = new FaultyProxy(target);
    proxy.#server.listen(0, '127.0.0.1');
    await once(proxy.#server, 'listening');
    proxy.url = `http://127.0.0.1:${(proxy.#server.address() as AddressInfo).port}`;
    return proxy;
  }

  stop(): void {
    this.#server.close();
    this.#server.closeAllConnections();
  }

  #serve(from: IncomingMessage, to: ServerResponse): void {
    this.seen.push(`${from.method} ${from.url}`);
    const index = this.faults.findIndex(({ on }) => from.url?.includes(on));
    const fault = index < 0 ? undefined : this.faults.splice(index, 1)[0]!.fault;
    if (fault && 'drop' in fault) {
      from.socket.destroy();
      return;
    }
    if (fault && 'status' in fault) {
      from.resume();
      to.writeHead(fault.status, fault.headers).end(fault.body);
      return;
    }
    const { hostname, port } = this.#target;
    const { method, url: path, headers } = from;
    const forward = request({ hostname, port, method, path, headers }, (reply) => {
      to.writeHead(reply.statusCode ?? 500, reply.headers);
      let left = fault ? fault.cutAfter : Infinity;
      reply.on('data', (chunk: Buffer) => {
        to.write(chunk.subarray(0, Math.min(left, chunk.length)));
        left -= chunk.length;
        if (left <= 0) setImmediate(() => to.socket?.destroy());
      });
      reply.on('end', () => to.end());
      reply.on('error', () => to.socket?.destroy());
    });
    forward.on('error', () => from.socket.destroy());
    to.on('close', () => forward.destroy());
    from.pipe(forward);
  }
}
