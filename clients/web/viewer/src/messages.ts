/**
 * A text for every error of the API: what is wrong in a few words, and what the reader
 * can do. What only the server knows (which parameter, which limit) is added from the
 * reply.
 */
import { GeodesicError, NetworkError, type ErrorCode } from 'geodesicd-client';
import { bytesText, countText } from './numbers.ts';

export interface Message {
  readonly title: string;
  readonly advice: string;
}

const TRY_AGAIN = 'Try again in a moment.';
const ANOTHER_EXPORT = 'Export the mesh as a GLB with triangles and try again.';
const OUR_FAULT = 'This page asked wrongly: reload it. If that does not help, report it with the id below.';

export const MESSAGES: Record<ErrorCode, Message> = {
  bad_syntax: { title: 'The request could not be read', advice: OUR_FAULT },
  unknown_parameter: { title: 'The server does not know this option', advice: 'It may be older than this page: reload it.' },
  route_unknown: { title: 'The server has no such service', advice: 'It may be older than this page: reload it.' },
  mesh_unknown: { title: 'This mesh is not on the server', advice: 'It was deleted, or never uploaded here. Drop its file again, or choose another mesh.' },
  method_not_allowed: { title: 'The server does not allow this', advice: OUR_FAULT },
  unauthorized: { title: 'This server asks for a token', advice: 'Enter one to go on.' },
  forbidden: { title: 'This is not allowed', advice: 'Ask whoever runs the server for a token with that scope, or to let this page change meshes.' },
  not_acceptable: { title: 'The server does not offer this format', advice: 'Choose another one.' },
  request_timeout: { title: 'The upload was too slow', advice: 'The server stopped waiting for the rest. Try again with a better connection.' },
  length_required: { title: 'The length of the upload is missing', advice: 'Something between this page and the server takes it away; ask whoever runs the server.' },
  too_large: { title: 'This is larger than the server allows', advice: 'Use a smaller mesh, or fewer points.' },
  format_unknown: { title: 'This file is no mesh that the server can read', advice: 'It takes .glb, .gltf with its files, .drc, .obj, .ply and .stl.' },
  mesh_invalid: { title: 'The mesh in this file is broken', advice: `The server found a fault in its data. ${ANOTHER_EXPORT}` },
  no_triangles: { title: 'There are no triangles in this file', advice: ANOTHER_EXPORT },
  too_many_vertices: { title: 'The mesh has too many vertices for this server', advice: 'Simplify it, or ask whoever runs the server for a higher limit.' },
  too_many_faces: { title: 'The mesh has too many faces for this server', advice: 'Simplify it, or ask whoever runs the server for a higher limit.' },
  external_uri: { title: 'This file needs other files', advice: 'Its data lies beside it. Choose or drop the .gltf together with its files, or their folder.' },
  extension_required: { title: 'This file needs a glTF extension that is not supported', advice: 'Export it without that extension.' },
  index_out_of_range: { title: 'This point is not on the mesh', advice: 'The link may belong to another mesh. Clear the points and place them again.' },
  value_out_of_range: { title: 'A value is outside of what is allowed', advice: 'Change it and try again.' },
  method_unknown: { title: 'The server does not have this method', advice: 'Choose another one from the list.' },
  snap_too_far: { title: 'This point is too far from the surface', advice: 'Place it on the surface.' },
  outside_region: { title: 'This point is not on the part of the surface that is asked about', advice: 'Place it on what is left.' },
  no_hit: { title: 'There is no surface there', advice: 'Click the mesh itself.' },
  no_loop: { title: 'There is no loop there', advice: 'Begin round a handle, a waist or a limb.' },
  unsupported: { title: 'The server does not offer this', advice: 'Choose another format or mesh.' },
  digest_mismatch: { title: 'The file changed on its way', advice: 'Upload it again.' },
  job_unknown: { title: 'This work is not there any more', advice: 'The server has forgotten it: start it again.' },
  job_unfinished: { title: 'This work has not ended yet', advice: TRY_AGAIN },
  job_cancelled: { title: 'This work was cancelled', advice: 'Start it again if it is wanted.' },
  too_much_memory: { title: 'This takes more memory than the server allows', advice: 'Choose the method auto, or a tolerance.' },
  overloaded: { title: 'The server has too much to do', advice: TRY_AGAIN },
  too_many_requests: { title: 'This page asked for too much at once', advice: TRY_AGAIN },
  draining: { title: 'The server is about to stop', advice: 'It will most likely be back soon.' },
  cancelled: { title: 'The work was cancelled', advice: 'Start it again if it is wanted.' },
  deadline: { title: 'This took longer than was allowed', advice: 'Choose a faster method or a smaller mesh.' },
  store_failed: { title: 'The server could not read or write its store', advice: 'Whoever runs it should look at its log.' },
  store_corrupt: { title: 'The stored mesh is damaged', advice: 'Upload its file again.' },
  store_full: { title: "The server's store is full", advice: 'Ask whoever runs it to make room.' },
  store_unavailable: { title: "The server's store does not answer", advice: TRY_AGAIN },
  internal: { title: 'The server made an error', advice: 'It is not yours. Report it with the id below.' },
};

const UNRECOGNISED: Message = {
  title: 'The answer did not come from geodesicd',
  advice: 'Something between this page and the server answered instead, such as a proxy.',
};

/** An error as its reader should see it: title, advice, and what the server said in detail. */
export interface Trouble extends Message {
  readonly detail: string;
  /** What it is about: the next success in it takes the message away. */
  readonly about?: string;
}

/** That a loop has as many points as the server takes. */
export const LOOP_IS_FULL: Trouble = {
  title: 'No more points of a loop', advice: 'The server takes a hundred: close the loop.', detail: '', about: 'points',
};

/** The same of a path. */
export const VIA_IS_FULL: Trouble = {
  title: 'No more via points', advice: 'The server takes a hundred.', detail: '', about: 'points',
};

/** That there are as many sources as the server takes; `count` were wanted at once. */
export function fullText(count?: number): Trouble {
  const taken = count === undefined ? '.' : `; the first of ${countText(count)} were taken.`;
  return { title: 'No more sources', advice: `The server takes a thousand${taken}`, detail: '', about: 'points' };
}

export function troubleOf(error: unknown): Trouble {
  if (error instanceof GeodesicError) {
    const known = Object.hasOwn(MESSAGES, error.code) ? MESSAGES[error.code as ErrorCode] : UNRECOGNISED;
    return { ...known, detail: detailOf(error) };
  }
  if (error instanceof NetworkError) {
    return { title: 'The server does not answer', advice: 'This page tries again by itself.', detail: '' };
  }
  return { title: 'Something went wrong in this page', advice: 'Reload it.', detail: String(error) };
}

function detailOf({ code, detail, parameter, limit, actual, requestId }: GeodesicError): string {
  // Of a parameter it is how many there are; of the body, or a reply, its bytes.
  const size = code === 'too_large' && parameter === undefined ? bytesText : countText;
  const bounds = [
    limit === undefined ? '' : `limit ${size(limit)}`,
    actual === undefined ? '' : `here ${size(actual)}`,
  ].filter(Boolean);
  const sentence = detail.charAt(0).toUpperCase() + detail.slice(1);
  return [sentence, bounds.join(', '), requestId ? `id ${requestId}` : ''].filter(Boolean).join(' · ');
}
