/** Requests to one server: its address, its token, and its errors as exceptions. */
import { errorOf, GeodesicError, NetworkError } from './errors.js';
import { withRetries, type RetryRules } from './retry.js';

/** A request before it is sent. */
export interface Call {
  method: 'GET' | 'HEAD' | 'POST' | 'PUT' | 'DELETE' | (string & {});
  /** From the server's root, percent-encoded, with the query: `/v1/status`. */
  path: string;
  headers?: Record<string, string>;
  body?: Blob | ArrayBuffer | Uint8Array | string;
  /** Whether to send it twice does no harm; without it, whether the HTTP method says so. */
  idempotent?: boolean;
  /** Whether 429 and 503 are tried again too; true without it. */
  retry?: boolean;
  /** Whether a browser is to send it although its page goes away. */
  keepalive?: boolean;
  signal?: AbortSignal | undefined;
}

/** A reply that has arrived whole. */
export interface Reply {
  status: number;
  headers: Headers;
  body: ArrayBuffer;
}

/** One try at a request, by whatever means. Rejects with NetworkError or the abort's reason. */
export type Sender = (url: string, call: Call, headers: Record<string, string>) => Promise<Reply>;

export interface TransportOptions extends RetryRules {
  token?: string | undefined;
  fetch?: typeof fetch | undefined;
}

const IDEMPOTENT = new Set(['GET', 'HEAD', 'PUT', 'DELETE', 'OPTIONS']);

export class Transport {
  readonly #base: string;
  readonly #options: TransportOptions;

  constructor(baseUrl: string, options: TransportOptions) {
    // A server behind a proxy may have a path of its own.
    this.#base = new URL(baseUrl).href.replace(/[?#].*$/s, '').replace(/\/+$/, '');
    this.#options = options;
  }

  get rules(): RetryRules {
    return this.#options;
  }

  url(path: string): string {
    return this.#base + path;
  }

  /** Sends a call and reads the whole reply. Throws GeodesicError for status 400 and above. */
  async exchange(call: Call, sender: Sender = this.#fetchWhole): Promise<Reply> {
    return this.#retried(call, async () => {
      const url = this.url(call.path);
      const reply = await sender(url, call, this.#headers(call));
      if (reply.status >= 400) throw errorOf(reply.status, reply.headers, reply.body, url);
      return reply;
    });
  }

  /** Sends a call; the reply's body is yet to be read. Throws as `exchange` does. */
  async open(call: Call): Promise<Response> {
    return this.#retried(call, async () => {
      const url = this.url(call.path);
      const response = await this.send(url, call, this.#headers(call));
      if (response.status < 400) return response;
      const body = await reading(call, url, () => response.arrayBuffer());
      throw errorOf(response.status, response.headers, body, url);
    });
  }

  #retried<T>(call: Call, attempt: () => Promise<T>): Promise<T> {
    const rules = call.retry === false ? { ...this.#options, retries: 0 } : this.#options;
    return withRetries(rules, call.idempotent ?? IDEMPOTENT.has(call.method), call.signal, attempt);
  }

  #headers(call: Call): Record<string, string> {
    const token = this.#options.token;
    if (token === undefined) return { ...call.headers };
    const headers = { Authorization: `Bearer ${token}`, ...call.headers };
    try {
      // Here, since from `fetch` it would pass for a lost connection.
      new Headers(headers);
    } catch (cause) {
      throw new TypeError('the token has a character that no header can carry', { cause });
    }
    return headers;
  }

  readonly #fetchWhole: Sender = async (url, call, headers) => {
    const response = await this.send(url, call, headers);
    const body = await reading(call, url, () => response.arrayBuffer());
    return { status: response.status, headers: response.headers, body };
  };

  /** One try by `fetch`. Rejects with NetworkError or the abort's reason. */
  send(url: string, call: Call, headers: Record<string, string>): Promise<Response> {
    const init: RequestInit = { method: call.method, headers };
    if (call.body !== undefined) init.body = call.body as BodyInit;
    if (call.signal) init.signal = call.signal;
    if (call.keepalive) init.keepalive = true;
    return reading(call, url, () => this.fetch(url, init));
  }

  /** By the client's own `fetch`, or else the platform's. */
  fetch(url: string, init: RequestInit): Promise<Response> {
    // Looked up at each call, so that a page may replace it (a service worker, a test). It is called
    // as a plain function, for a browser's refuses to be a method of something else.
    const send = this.#options.fetch ?? globalThis.fetch;
    return send(url, init);
  }
}

/** Whatever fails under way is a NetworkError, but for an abort. */
export async function reading<T>(call: Call, url: string, act: () => Promise<T>): Promise<T> {
  try {
    return await act();
  } catch (cause) {
    call.signal?.throwIfAborted();
    if (cause instanceof GeodesicError || cause instanceof NetworkError) throw cause;
    throw new NetworkError(url, cause);
  }
}
