/** A stream of bytes as lines of text, each as soon as it has arrived. */
import { chunksOf } from './chunks.js';

/**
 * The lines of `body`, without their ends (LF or CR LF). Whoever stops early ends the
 * request: the body is cancelled.
 */
export async function* linesOf(body: ReadableStream<Uint8Array>): AsyncGenerator<string> {
  const decoder = new TextDecoder();
  let rest = '';
  for await (const chunk of chunksOf(body)) {
    rest += decoder.decode(chunk, { stream: true });
    let end: number;
    let start = 0;
    while ((end = rest.indexOf('\n', start)) >= 0) {
      yield rest.slice(start, rest[end - 1] === '\r' ? end - 1 : end);
      start = end + 1;
    }
    rest = rest.slice(start);
  }
  rest += decoder.decode();
  if (rest !== '') yield rest;
}
