/** The link to what is seen, for others: where fingers point by the device's own sheet, else on the clipboard. */
import type { AddressBar } from './address_bar.ts';
import { linkOf, tooMuchPainted } from './link.ts';
import type { State } from './state.ts';

/** `say` tells something that is soon forgotten. */
export async function shareLink(state: State, address: AddressBar, say: (text: string) => void): Promise<void> {
  const link = new URL(`#${linkOf(state)}`, location.href).href;
  address.writeNow();
  if (tooMuchPainted(state)) return say('More is painted than a link can hold: this one is without it');
  if (matchMedia('(pointer: coarse)').matches && navigator.canShare?.({ url: link })) {
    return navigator.share({ title: document.title, url: link }).catch(() => undefined); // changed their mind
  }
  try {
    await navigator.clipboard.writeText(link);
    say('The link is on the clipboard');
  } catch {
    say('The link is in the address bar'); // clipboards need https or localhost
  }
}
