// The page: every operation of /openapi.json in its group, then the errors and the
// schemas, with a list of contents that follows and can be searched.
import {code, coloured, inline, make, markdown, scroll} from './text.js';
import {details, exampleOf, members, resolve, use} from './schema.js';
import {contract} from './place.js';
import {offerMeshes, tryIt} from './request.js';

const kMethods = ['get', 'head', 'post', 'put', 'patch', 'delete'];

function operationsOf(openapi) {
  return Object.entries(openapi.paths).flatMap(([path, item]) => kMethods.filter((method) => item[method])
    .map((method) => {
      const operation = item[method];
      return {
        path, method: method.toUpperCase(), ...operation,
        id: operation.operationId ?? `${method}-${path.replace(/\W+/g, '-')}`,
        parameters: [...(item.parameters ?? []), ...(operation.parameters ?? [])].map(resolve),
        body: operation.requestBody && resolve(operation.requestBody),
        authorised: (operation.security ?? openapi.security ?? []).length > 0,
      };
    }));
}

const badge = (method) => make(`span.method.${method.toLowerCase()}`, {}, method);

function pathOf(path) {
  return path.split(/(\{[^}]+\})/).filter(Boolean)
    .map((part) => (part.startsWith('{') ? make('var', {}, part) : part));
}

// The replies of an operation: a line a status, open for what is in it.
function replies(operation) {
  return Object.entries(operation.responses).map(([status, node]) => {
    const reply = resolve(node);
    const headers = Object.entries(reply.headers ?? {});
    const types = Object.entries(reply.content ?? {});
    const schemas = types.filter(([, media]) => media.schema);
    return make('details.reply', {}, make('summary', {},
      make(`span.code-${status[0]}`, {}, status === 'default' ? 'else' : status), ' ', inline(reply.description.trim())),
    schemas.length ? members(schemas.map(([type, media]) => ({
      name: type, schema: media.schema, description: media.schema.$ref ? '' : media.schema.description,
    }))) : null,
    headers.length ? [make('h5', {}, 'Headers'), members(headers.map(([name, header]) => {
      const {schema, description} = resolve(header);
      return {name, schema, description};
    }))] : null);
  });
}

// What the first good reply looks like.
function exampleReply(operation) {
  const [status, node] = Object.entries(operation.responses).find(([code]) => code.startsWith('2')) ?? [];
  const content = resolve(node)?.content ?? {};
  const type = Object.keys(content).find((name) => name.endsWith('json')) ?? Object.keys(content)[0];
  const example = exampleOf(content[type]);
  if (example === undefined) return null;
  return code(type.endsWith('json') ? coloured(example) : String(example), `${status}  ${type}`);
}

function section(operation) {
  const parameters = operation.parameters;
  const bodies = Object.entries(operation.body?.content ?? {});
  return make('section.operation', {id: operation.id, 'data-operation': `${operation.method} ${operation.path}`},
    make('.prose', {},
      make('h3', {}, make('a', {href: `#${operation.id}`}, operation.summary ?? operation.id)),
      make('p.route', {}, badge(operation.method), make('code', {}, pathOf(operation.path))),
      markdown(operation.description),
      parameters.length ? [make('h4', {}, 'Parameters'), members(parameters)] : null,
      bodies.length ? [make('h4', {}, 'Body'), make('p', {}, inline(operation.body.description ?? '')),
        members(bodies.map(([type, media]) => ({name: type, schema: media.schema,
          description: media.schema?.$ref ? '' : media.schema?.description})))] : null,
      make('h4', {}, 'Replies'), replies(operation)),
    make('.examples', {}, tryIt(operation), exampleReply(operation)));
}

// Each code with the statuses that it comes with, as the descriptions of replies tell.
function errors(openapi, operations) {
  const codes = openapi.components?.schemas?.ErrorCode?.enum ?? [];
  const found = new Map(codes.map((code) => [code, {statuses: new Set(), operations: new Set()}]));
  for (const operation of operations) {
    for (const [status, node] of Object.entries(operation.responses)) {
      for (const [, name] of (resolve(node).description ?? '').matchAll(/`([a-z_]+)`/g)) {
        if (!found.has(name)) continue;
        if (status !== 'default') found.get(name).statuses.add(status);
        found.get(name).operations.add(operation);
      }
    }
  }
  return make('section.plain', {id: 'errors'}, make('h2', {}, 'Errors'),
    make('p', {}, 'Every error is ', make('code', {}, 'application/problem+json'), ', a ',
      make('a', {href: '#schema-Problem'}, 'Problem'), '. The codes, and the operations that name them:'),
    scroll(make('table.members', {}, make('tbody', {}, codes.map((code) => {
      const {statuses, operations: by} = found.get(code);
      const ids = [...by].map((operation) => make('a', {href: `#${operation.id}`}, operation.id));
      return make('tr', {id: code}, make('td', {}, make('code.name', {}, code)),
        make('td', {}, [...statuses].map((status) => make(`span.code-${status[0]}`, {}, status))),
        make('td.ids', {}, ids.length > 6
          ? make('details', {}, make('summary', {}, `${ids.length} operations`), ids.flatMap((id) => [id, ' ']))
          : ids.flatMap((id) => [id, ' '])));
    })))));
}

function schemas(openapi) {
  return make('section.plain', {id: 'schemas'}, make('h2', {}, 'Schemas'),
    Object.entries(openapi.components?.schemas ?? {}).map(([name, schema]) => make('section.operation', {id: `schema-${name}`},
      make('.prose', {}, make('h3', {}, make('a', {href: `#schema-${name}`}, name)),
        markdown(schema.description), details(schema)),
      make('.examples', {}, (schema.examples ?? []).length
        ? code(coloured(schema.examples[0]), 'Example') : null))));
}

function contents(groups, openapi) {
  const link = (id, ...label) => make('a', {href: `#${id}`}, label);
  return [
    make('.group', {}, link('about', 'About')),
    ...groups.map(({tag, operations}) => make('.group', {}, make('h2', {}, tag.name),
      operations.map((operation) => link(operation.id, badge(operation.method),
        make('span', {}, operation.summary ?? operation.id))))),
    make('.group', {}, make('h2', {}, 'reference'), link('errors', 'Errors'), link('schemas', 'Schemas'),
      make('.schemas', {}, Object.keys(openapi.components?.schemas ?? {}).map((name) => link(`schema-${name}`, name)))),
  ];
}

// Marks in the contents what is being read.
function follow() {
  const links = new Map([...document.querySelectorAll('#contents a')]
    .map((link) => [link.getAttribute('href').slice(1), link]));
  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      document.querySelector('#contents a[aria-current]')?.removeAttribute('aria-current');
      const link = links.get(entry.target.id);
      link?.setAttribute('aria-current', 'true');
      link?.scrollIntoView({block: 'nearest'});
    }
  }, {rootMargin: '-15% 0px -75% 0px'});
  for (const element of document.querySelectorAll('main section[id]')) observer.observe(element);
}

// Leaves only the operations and schemas that have every word, and their headings.
function search() {
  const input = document.getElementById('search');
  input.addEventListener('input', () => {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const element of document.querySelectorAll('section.operation')) {
      const text = `${element.dataset.operation ?? ''} ${element.querySelector('.prose').textContent}`.toLowerCase();
      element.hidden = !words.every((word) => text.includes(word));
      const link = document.querySelector(`#contents a[href="#${element.id}"]`);
      if (link) link.hidden = element.hidden;
    }
    for (const group of document.querySelectorAll('#main > section.group')) {
      group.hidden = words.length > 0 && !group.querySelector('section.operation:not([hidden])');
    }
    document.getElementById('about').hidden = words.length > 0;
  });
  document.addEventListener('keydown', (event) => {
    if (event.key !== '/' || /INPUT|TEXTAREA|SELECT/.test(document.activeElement.tagName)) return;
    event.preventDefault();
    input.focus();
  });
}

function draw(openapi) {
  use(openapi);
  const operations = operationsOf(openapi);
  const named = openapi.tags ?? [];
  const others = [...new Set(operations.flatMap((operation) => operation.tags ?? ['other']))]
    .filter((name) => !named.some((tag) => tag.name === name)).map((name) => ({name}));
  const groups = [...named, ...others].map((tag) => ({
    tag, operations: operations.filter((operation) => (operation.tags ?? ['other'])[0] === tag.name),
  })).filter((group) => group.operations.length);

  const {title, version, summary, description} = openapi.info;
  document.getElementById('version').textContent = version;
  document.getElementById('token-field').hidden = !openapi.components?.securitySchemes;
  document.getElementById('contents').replaceChildren(...contents(groups, openapi));
  document.getElementById('main').replaceChildren(
    make('section.plain', {id: 'about'}, make('h1', {}, title), make('p.lead', {}, summary ?? ''), markdown(description)),
    ...groups.map(({tag, operations: list}) => make('section.group', {id: `tag-${tag.name}`},
      make('h2', {}, tag.name), make('p.lead', {}, tag.description ?? ''), list.map(section))),
    errors(openapi, operations), schemas(openapi));
  search();
  follow();
  document.getElementById(decodeURIComponent(location.hash.slice(1)))?.scrollIntoView();
}

try {
  const reply = await fetch(contract);
  if (!reply.ok) throw new Error(`the server answers ${reply.status}`);
  draw(await reply.json());
  document.getElementById('token').addEventListener('change', offerMeshes);
  await offerMeshes();
} catch (error) {
  document.getElementById('main').replaceChildren(make('p', {}, `${contract} cannot be shown: ${error.message}`));
}
