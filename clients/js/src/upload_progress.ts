/**
 * Sending a body with its progress told: by XMLHttpRequest in browsers, whose `fetch` does
 * not tell; elsewhere by the client's `fetch` with a stream that counts what is drawn from it.
 */
import { NetworkError } from './errors.js';
import { reading, type Call, type Sender, type Transport } from './transport.js';

type Progress = (sentBytes: number, totalBytes: number) => void;

export function senderWithProgress(transport: Transport, onProgress: Progress): Sender {
  return typeof XMLHttpRequest === 'undefined'
    ? (url, call, headers) => sendCounted(transport, url, call, headers, onProgress)
    : (url, call, headers) => sendByXhr(url, call, headers, onProgress);
}

const sendByXhr = (
  url: string,
  call: Call,
  headers: Record<string, string>,
  onProgress: Progress,
): ReturnType<Sender> =>
  new Promise((resolve, reject) => {
    const xhr = new XMLHttpRequest();
    const stop = () => xhr.abort();
    const settled = (settle: () => void) => () => {
      call.signal?.removeEventListener('abort', stop);
      settle();
    };
    xhr.open(call.method, url);
    xhr.responseType = 'arraybuffer';
    for (const [name, value] of Object.entries(headers)) xhr.setRequestHeader(name, value);
    xhr.upload.onprogress = (event) => onProgress(event.loaded, sizeOf(call));
    xhr.onload = settled(() =>
      resolve({
        status: xhr.status,
        headers: headersOf(xhr.getAllResponseHeaders()),
        body: (xhr.response as ArrayBuffer | null) ?? new ArrayBuffer(0),
      }),
    );
    xhr.onerror = settled(() => reject(new NetworkError(url, 'the connection failed')));
    xhr.onabort = settled(() => reject(call.signal?.reason));
    call.signal?.addEventListener('abort', stop, { once: true });
    xhr.send(call.body as XMLHttpRequestBodyInit);
  });

function headersOf(text: string): Headers {
  const headers = new Headers();
  for (const line of text.split('\r\n')) {
    const colon = line.indexOf(':');
    if (colon > 0) headers.append(line.slice(0, colon), line.slice(colon + 1).trim());
  }
  return headers;
}

function sizeOf(call: Call): number {
  const body = call.body as Blob | ArrayBuffer | Uint8Array;
  return body instanceof Blob ? body.size : body.byteLength;
}

async function sendCounted(
  transport: Transport,
  url: string,
  call: Call,
  headers: Record<string, string>,
  onProgress: Progress,
): ReturnType<Sender> {
  const total = sizeOf(call);
  const init = {
    method: call.method,
    headers: { ...headers, 'Content-Length': String(total) }, // else it goes in chunks
    body: counted(call.body as Blob | ArrayBuffer | Uint8Array, total, onProgress),
    duplex: 'half',
    ...(call.signal && { signal: call.signal }),
  };
  return reading(call, url, async () => {
    const response = await transport.fetch(url, init as RequestInit);
    return {
      status: response.status,
      headers: response.headers,
      body: await response.arrayBuffer(),
    };
  });
}

/** The bytes in pieces, each told of when the next is drawn: then it has left. */
function counted(
  body: Blob | ArrayBuffer | Uint8Array,
  total: number,
  onProgress: Progress,
): ReadableStream<Uint8Array> {
  const blob = body instanceof Blob ? body : new Blob([body as BlobPart]);
  const piece = 65536;
  let drawn = 0;
  return new ReadableStream<Uint8Array>(
    {
      async pull(controller) {
        onProgress(drawn, total);
        if (drawn === total) {
          controller.close();
          return;
        }
        const end = Math.min(drawn + piece, total);
        controller.enqueue(new Uint8Array(await blob.slice(drawn, end).arrayBuffer()));
        drawn = end;
      },
    },
    { highWaterMark: 0 },
  );
}
