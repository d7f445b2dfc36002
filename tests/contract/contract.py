"""The OpenAPI document as what a test asks of it: operations, the requests that its
examples make, and whether a reply is one that it describes."""

import copy
import json
import re
import urllib.parse

from jsonschema import Draft202012Validator, FormatChecker

METHODS = ("get", "head", "post", "put", "patch", "delete")

# What a schema of the document may say; every other key is a slip of the pen, such as
# the end of a description that has a comma and no quotes.
SCHEMA_OF_NAMES = ("properties",)
SCHEMAS_IN_LISTS = ("allOf", "anyOf", "oneOf", "prefixItems")
SCHEMA_IN = ("items", "additionalProperties", "not")
SCHEMA_VALUES = (
    *("$ref", "type", "format", "enum", "const", "default", "pattern", "description", "title"),
    *("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "multipleOf", "required"),
    *("minLength", "maxLength", "minItems", "maxItems", "minProperties", "maxProperties"),
    *("uniqueItems", "contentMediaType", "contentEncoding", "example", "examples", "deprecated"),
    *("discriminator", "contentSchema", "readOnly", "writeOnly"),
)


class Operation:
    """One method of one path."""

    def __init__(self, contract, path, method, item):
        node = item[method]
        self.contract = contract
        self.path, self.method, self.node = path, method.upper(), node
        self.id = node["operationId"]
        every = item.get("parameters", []) + node.get("parameters", [])
        self.parameters = [contract.resolve(parameter) for parameter in every]
        self.body = contract.resolve(node["requestBody"]) if "requestBody" in node else None
        self.responses = {
            status: contract.resolve(reply) for status, reply in node["responses"].items()
        }

    def parameters_in(self, place):
        """Those of the path, the query or the header."""
        return [parameter for parameter in self.parameters if parameter["in"] == place]

    def target(self, query=(), **path):
        """The URL's path and query, with examples where nothing is given."""
        filled = self.path
        for parameter in self.parameters_in("path"):
            value = path.get(parameter["name"], self.contract.example_of(parameter))
            filled = filled.replace("{%s}" % parameter["name"], urllib.parse.quote(str(value)))
        return filled + ("?" + urllib.parse.urlencode(query, safe=":,") if query else "")

    def example_query(self, all_of_them=False):
        """The required parameters of the URL, or all with an example, as pairs."""
        pairs = []
        for parameter in self.parameters_in("query"):
            value = parameter.get("example")
            if parameter.get("required") and value is None:
                value = self.contract.example_of(parameter)
            if value is None or not (parameter.get("required") or all_of_them):
                continue
            values = value if isinstance(value, list) else [value]
            pairs += [(parameter["name"], one) for one in values]
        return pairs

    def example_bodies(self):
        """(type, value) of each example that a body has; of its schema too."""
        for kind, media in (self.body or {}).get("content", {}).items():
            for value in self.contract.examples_of(media):
                yield kind, value

    def codes(self, status):
        """The error codes that the description of a status names."""
        text = self.responses.get(status, {}).get("description", "")
        return [code for code in re.findall(r"`([a-z_]+)`", text) if code in self.contract.codes]


class Contract:
    """The document, parsed."""

    def __init__(self, document):
        self.document = document
        self.codes = document["components"]["schemas"]["ErrorCode"]["enum"]
        self._validator = Draft202012Validator(document, format_checker=FormatChecker())
        self.operations = [
            Operation(self, path, method, item)
            for path, item in document["paths"].items()
            for method in METHODS
            if method in item
        ]

    def unknown_keys(self):
        """Where a schema has a key that no schema has, or anything a key that says nothing."""

        def of_schema(node, path):
            if not isinstance(node, dict):
                return
            for key, value in node.items():
                if key in SCHEMA_OF_NAMES:
                    for name, one in value.items():
                        yield from of_schema(one, f"{path}.{key}.{name}")
                elif key in SCHEMAS_IN_LISTS:
                    for index, one in enumerate(value):
                        yield from of_schema(one, f"{path}.{key}[{index}]")
                elif key in SCHEMA_IN:
                    yield from of_schema(value, f"{path}.{key}")
                elif key not in SCHEMA_VALUES:
                    yield f"{path}.{key}"

        def of_any(node, path):
            if isinstance(node, list):
                for index, one in enumerate(node):
                    yield from of_any(one, f"{path}[{index}]")
            if not isinstance(node, dict):
                return
            for key, value in node.items():
                if key == "schema":
                    yield from of_schema(value, f"{path}.{key}")
                elif value is None:
                    yield f"{path}.{key}"
                elif key not in ("example", "examples", "schemas"):
                    yield from of_any(value, f"{path}.{key}")

        yield from of_any(self.document, "")
        for name, schema in self.document["components"]["schemas"].items():
            yield from of_schema(schema, f".components.schemas.{name}")

    def resolve(self, node):
        """The node that a reference means; what stands beside one counts first."""
        while "$ref" in node:
            target = self.document
            for key in node["$ref"][2:].split("/"):
                target = target[key.replace("~1", "/").replace("~0", "~")]
            node = {**target, **{key: value for key, value in node.items() if key != "$ref"}}
        return node

    def examples_of(self, node):
        """The examples of a media type, parameter, header or schema, and of its schema."""
        if "example" in node:
            yield node["example"]
        examples = node.get("examples", [])
        if isinstance(examples, dict):
            yield from (self.resolve(example)["value"] for example in examples.values())
        else:
            yield from examples
        if "schema" in node:
            yield from self.examples_of(self.resolve(node["schema"]))

    def example_of(self, node):
        """The first of them."""
        return copy.deepcopy(next(self.examples_of(node)))

    def errors(self, value, schema):
        """What is wrong with a value, as texts."""
        found = self._validator.evolve(schema=schema).iter_errors(value)
        return [f"{error.json_path}: {error.message[:300]}" for error in found]

    def wrong(self, operation, reply):
        """What of a reply is not as described, as texts."""
        described = operation.responses.get(str(reply.status)) or operation.responses.get("default")
        if described is None:
            return [f"the status {reply.status} is not described"]
        found = self._wrong_headers(described, reply)
        content = described.get("content", {})
        kind = reply.headers.get("content-type", "").split(";")[0]
        if operation.method == "HEAD" or not content:
            return found + ([f"a body of {len(reply.body)} bytes"] if reply.body else [])
        if kind not in content:
            return (
                found
                if "*/*" in content
                else found + [f"the type {kind or 'none'} is not described"]
            )
        if kind == "application/x-ndjson":
            # Which schema a line has, OpenAPI 3.1 can only say in words.
            line = re.search(r"Lines of (#/\S+)", content[kind]["schema"].get("description", ""))
            for text in reply.body.splitlines():
                found += self.errors(json.loads(text), {"$ref": line[1]} if line else {})
        elif kind.endswith("json"):
            value = json.loads(reply.body)
            found += self.errors(value, content[kind].get("schema", {}))
            if kind == "application/problem+json":
                found += self._wrong_problem(operation, reply, value)
        return found

    def _wrong_headers(self, described, reply):
        found = []
        for name, header in described.get("headers", {}).items():
            header = self.resolve(header)
            text = reply.headers.get(name.lower())
            if text is None:
                if header.get("required"):
                    found.append(f"the header {name} is missing")
                continue
            schema = self.resolve(header.get("schema", {}))
            value = text
            if schema.get("type") in ("integer", "number"):
                value = json.loads(text)
            found += [f"the header {name}: {error}" for error in self.errors(value, schema)]
        return found

    def _wrong_problem(self, operation, reply, problem):
        found = []
        if problem.get("status") != reply.status:
            found.append(f"a status of {problem.get('status')} within one of {reply.status}")
        if str(reply.status) in operation.responses:
            named = operation.codes(str(reply.status))
            if problem.get("code") not in named:
                found.append(f"the code {problem.get('code')} is none of {named}")
        return found
