/** A stream of bytes as lines of text, each as soon as it has arrived. */

/**
 * The lines of `body`, without their ends (LF or CR LF). Whoever stops early ends the
 * request: the body is cancelled.
 */
export async function* linesOf(body: ReadableStream<Uint8Array>): AsyncGenerator<string> {
  const reader = body.getReader();
  const decoder = new TextDecoder();
  let rest = '';
  let ended = false;
  try {
    while (!ended) {
      const { done, value } = await reader.read();
      ended = done;
      rest += done ? decoder.decode() : decoder.decode(value, { stream: true });
      let end: number;
      let start = 0;
      while ((end = rest.indexOf('\n', start)) >= 0) {
        yield rest.slice(start, rest[end - 1] === '\r' ? end - 1 : end);
        start = end + 1;
      }
      rest = rest.slice(start);
    }
    if (rest !== '') yield rest;
  } finally {
    if (!ended) await reader.cancel().catch(() => undefined);
  }
}
