// A proxy that has a service under a path of its own, `/geo/`, and takes that off; anything
// else on its host is not there.
import { once } from 'node:events';
import { createServer, request } from 'node:http';
import { after } from 'node:test';

/**
 * `host`: the one that the service is told, instead of the browser's. The page then is of
 * another origin by all that it says: over plain http no browser says `Sec-Fetch-Site`,
 * but for localhost. `through`: from a target and the reply's stream to what is passed on.
 */
export async function proxied(service, { host, through } = {}) {
  const lost = []; // targets outside of the path
  const proxy = createServer((asked, answer) => {
    if (!asked.url.startsWith('/geo/')) {
      lost.push(asked.url);
      return answer.writeHead(404).end();
    }
    const { port } = service;
    const headers = { ...asked.headers, ...(host && { host }) };
    if (host) delete headers['sec-fetch-site'];
    const passed = request({ host: '127.0.0.1', port, method: asked.method, path: asked.url.slice(4), headers }, (reply) => {
      answer.writeHead(reply.statusCode, reply.headers);
      const passes = through ? through(asked.url, reply) : reply;
      passes.on('error', () => answer.destroy()).pipe(answer);
    });
    passed.on('error', () => answer.destroy());
    answer.on('close', () => passed.destroy());
    asked.pipe(passed);
  });
  proxy.listen(0, '127.0.0.1');
  await once(proxy, 'listening');
  after(() => {
    proxy.closeAllConnections();
    proxy.close();
  });
  return { url: `http://127.0.0.1:${proxy.address().port}/geo/`, lost };
}
