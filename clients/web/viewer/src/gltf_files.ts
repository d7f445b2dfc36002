/** Which of the files beside a .gltf are its own: those that it names for its buffers. */

/** Their names as the server looks for them; none where the file cannot be read, which the server tells. */
export async function buffersOf(gltf: Blob): Promise<string[]> {
  try {
    const { buffers } = JSON.parse(await gltf.text()) as { buffers: readonly { readonly uri?: unknown }[] };
    const uris = buffers.map(({ uri }) => uri).filter((uri) => typeof uri === 'string' && !uri.startsWith('data:')) as string[];
    return [...new Set(uris.map((uri) => decoded(uri).replace(/^\.\//, '')))];
  } catch {
    return [];
  }
}

/** What is no escape stays as it is. */
function decoded(uri: string): string {
  return uri.replace(/(%[0-9a-f]{2})+/gi, (escapes) => {
    try {
      return decodeURIComponent(escapes);
    } catch {
      return escapes;
    }
  });
}
