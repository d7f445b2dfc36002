/**
 * Server-sent events out of a reply's body. `EventSource` cannot send a token, and Node 18
 * has none.
 */
import { linesOf } from './lines.js';

export interface ServerEvent {
  /** `message` where the stream names none. */
  event: string;
  data: string;
  id: string | undefined;
}

/** The events of a `text/event-stream`, each as soon as it has arrived. */
export async function* eventsOf(body: ReadableStream<Uint8Array>): AsyncGenerator<ServerEvent> {
  let event = 'message';
  let id: string | undefined;
  let data: string[] = [];
  for await (const line of linesOf(body)) {
    if (line === '') {
      if (data.length > 0) yield { event, data: data.join('\n'), id };
      event = 'message';
      data = [];
      continue;
    }
    const colon = line.indexOf(':');
    const field = colon < 0 ? line : line.slice(0, colon); // empty: a comment
    const value = colon < 0 ? '' : line.slice(colon + 1).replace(/^ /, '');
    if (field === 'event') event = value;
    if (field === 'id') id = value;
    if (field === 'data') data.push(value);
  }
}
