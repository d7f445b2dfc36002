/** Names of meshes: the one that a file brings along, cut to what the server takes. */

/** UTF-8 bytes of a name at most. */
const MOST_BYTES = 200;

/**
 * What the server takes in no name (proto/wire/mesh_name.cpp): control characters, and what breaks
 * lines or turns the direction of what follows. Half a surrogate pair is no character: the URL
 * could not carry it.
 */
const IN_NO_NAME = /[\p{Cc}\p{Cs}\u2028-\u202e\u2066-\u2069]/u;

/** What a file may be that knows its name: a `File`, or a file among several. */
interface Named {
  readonly name?: unknown;
}

/**
 * The last part of a file's name, without what the server takes in no name and at most 200 bytes
 * long in UTF-8; undefined where nothing is left. Nobody has asked for this name, so no upload is
 * to fail for it. The end stays, since it says the format.
 */
export function fileName({ name }: Named): string | undefined {
  if (typeof name !== 'string') return undefined;
  const base = name.split(/[/\\]/).at(-1)!;
  const characters = Array.from(base).filter((one) => !IN_NO_NAME.test(one));
  const encoder = new TextEncoder();
  let bytes = 0;
  let kept = characters.length;
  while (kept > 0 && (bytes += encoder.encode(characters[kept - 1]).length) <= MOST_BYTES) --kept;
  return characters.slice(kept).join('').trim() || undefined;
}
