// Schemas of the document as elements: what a value is, in a line, and the members
// that an object has, in a table.
import {inline, make, scroll} from './text.js';

let document_ = {};
export function use(openapi) { document_ = openapi; }

// Follows a reference, and those it leads to; what stands beside one counts first.
export function resolve(node) {
  let found = node;
  while (found && found.$ref) {
    const {$ref, ...beside} = found;
    const target = $ref.slice(2).split('/').reduce(
      (at, key) => at?.[key.replace(/~1/g, '/').replace(/~0/g, '~')], document_);
    found = {...target, ...beside};
  }
  return found ?? {};
}

const nameOf = (schema) => schema?.$ref?.match(/^#\/components\/schemas\/(.+)$/)?.[1];

function bounds(schema) {
  const {minimum, maximum, exclusiveMinimum} = schema;
  if (minimum !== undefined && maximum !== undefined) return ` ${minimum} … ${maximum}`;
  if (minimum !== undefined) return ` ≥ ${minimum}`;
  if (exclusiveMinimum !== undefined) return ` > ${exclusiveMinimum}`;
  if (maximum !== undefined) return ` ≤ ${maximum}`;
  return '';
}

function joined(parts, between) {
  return parts.flatMap((part, index) => (index ? [between, part] : [part]));
}

// What a value is, in a few words; schemas with a name lead to it.
export function kindOf(schema) {
  if (!schema) return ['anything'];
  const name = nameOf(schema);
  if (name) return [make('a', {href: `#schema-${name}`}, name)];
  const choices = schema.oneOf ?? schema.anyOf;
  if (choices) return joined(choices.map(kindOf), ' or ');
  if (schema.enum) return joined(schema.enum.map((value) => make('code', {}, String(value))), ' ');
  const types = [schema.type ?? []].flat();
  if (types.includes('array')) {
    const {minItems: least, maxItems: most} = schema;
    const count = least !== undefined && least === most ? `${least} ` : '';
    return [`array of ${count}`, ...kindOf(schema.items)];
  }
  if (!types.length) return [schema.description ? 'bytes' : 'anything'];
  return [types.join(' or ') + bounds(schema)];
}

export function defaultOf(schema) {
  const value = resolve(schema).default;
  return value === undefined ? [] : [' ', make('span.muted', {}, 'default '), make('code', {}, String(value))];
}

// A table of members or parameters: {name, required, schema, description}.
export function members(rows) {
  return scroll(make('table.members', {}, make('tbody', {}, rows.map((row) => make('tr', {},
    make('td', {}, make('code.name', {}, row.name),
      row.required ? make('span.required', {title: 'required'}, 'required') : null),
    make('td', {}, make('.kind', {}, kindOf(row.schema), defaultOf(row.schema)),
      make('.about', {}, inline((row.description ?? '').replace(/\s+/g, ' ').trim())),
      nested(row.schema)))))));
}

// The members of an object that has no name of its own.
function nested(schema) {
  if (!schema || nameOf(schema)) return null;
  if (schema.properties) return properties(schema);
  if (schema.items) return nested(schema.items);
  return null;
}

function properties(schema) {
  return members(Object.entries(schema.properties).map(([name, member]) => ({
    name,
    required: schema.required?.includes(name),
    schema: member,
    description: member.description ?? (nameOf(member) ? '' : resolve(member).description),
  })));
}

// All that a schema says.
export function details(schema) {
  const parts = [];
  if (schema.properties) return [properties(schema)];
  for (const choice of schema.oneOf ?? schema.anyOf ?? []) {
    parts.push(make('.choice', {},
      make('p', {}, make('strong', {}, choice.title ?? 'Either'), ': ', kindOf(choice)),
      choice.properties ? properties(choice) : null));
  }
  if (parts.length) return parts;
  parts.push(make('p.kind', {}, kindOf(schema), defaultOf(schema)));
  if (schema.pattern) parts.push(make('p', {}, 'as in ', make('code', {}, schema.pattern)));
  return parts;
}

// The first example that a media type, parameter or schema has; undefined: none.
export function exampleOf(node) {
  if (!node) return undefined;
  if (node.example !== undefined) return node.example;
  if (node.examples && !Array.isArray(node.examples)) {
    return resolve(Object.values(node.examples)[0]).value;
  }
  if (Array.isArray(node.examples)) return node.examples[0];
  return node.schema || node.$ref ? exampleOf(resolve(node.schema ?? node)) : undefined;
}
