/** Files of sources: how large one may be, since the page reads it whole. */
import type { Trouble } from './messages.ts';
import { bytesText } from './numbers.ts';

/** Many times what a thousand points take; more lets the page stand still. */
const MOST_BYTES = 5e6;

/** What is said of a file that is too large to be read; null of others. */
export function tooLarge({ name, size }: File): Trouble | null {
  if (size <= MOST_BYTES) return null;
  return {
    title: 'This file is too large for a list of sources',
    advice: `It may have ${bytesText(MOST_BYTES)}: a vertex number, or x y z, on each line.`,
    detail: `${name}: ${bytesText(size)}`,
  };
}
