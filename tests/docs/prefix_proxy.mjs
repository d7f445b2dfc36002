// A proxy in front of a service that takes a prefix off, as nginx does with `location /geo/`.
import { createServer, request } from 'node:http';

export const PREFIX = '/geo';

/** Its address, with the prefix and a slash at the end, and a way to stop it. */
export async function proxied(service) {
  const server = createServer((asked, reply) => {
    if (!asked.url.startsWith(`${PREFIX}/`)) {
      reply.writeHead(404).end('not below the prefix');
      return;
    }
    const { method, headers } = asked;
    const path = asked.url.slice(PREFIX.length);
    const passed = request({ host: '127.0.0.1', port: service.port, path, method, headers }, (answer) => {
      reply.writeHead(answer.statusCode, answer.headers);
      answer.pipe(reply);
    });
    passed.on('error', () => reply.destroy());
    asked.pipe(passed);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}${PREFIX}/`,
    stop: () => { server.closeAllConnections(); server.close(); },
  };
}
