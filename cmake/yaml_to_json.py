#!/usr/bin/env python3
"""yaml_to_json.py INPUT OUTPUT: a YAML document as JSON, members in their order.

Read by the core schema of YAML 1.2, as OpenAPI 3.1 asks; PyYAML's own is 1.1, to which
`no` is false and `12:30` is 750."""

import json
import math
import re
import sys

import yaml


class CoreSchemaLoader(yaml.SafeLoader):
    """PyYAML's safe loader with YAML 1.2's rules of what a plain text is."""

    yaml_implicit_resolvers = {}


_RULES = (
    ("null", r"null|Null|NULL|~|", "nN~", ""),
    ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF", None),
    ("int", r"[-+]?[0-9]+", "-+0123456789", None),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789", None),
)
for _name, _pattern, _first, _empty in _RULES:
    CoreSchemaLoader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_name}",
        re.compile(f"^(?:{_pattern})$"),
        list(_first) + ([_empty] if _empty is not None else []),
    )
CoreSchemaLoader.add_constructor(
    "tag:yaml.org,2002:int", lambda loader, node: int(loader.construct_scalar(node))
)
CoreSchemaLoader.add_constructor(
    "tag:yaml.org,2002:float", lambda loader, node: float(loader.construct_scalar(node))
)


def _no_key_twice(loader, node, deep=False):
    keys = [loader.construct_object(key, deep=deep) for key, _ in node.value]
    twice = sorted({str(key) for key in keys if keys.count(key) > 1})
    if twice:
        raise yaml.constructor.ConstructorError(
            None, None, f"twice in one mapping: {', '.join(twice)}", node.start_mark
        )
    mapping = {}
    yield mapping
    mapping.update(loader.construct_mapping(node, deep=True))


CoreSchemaLoader.add_constructor("tag:yaml.org,2002:map", _no_key_twice)


def _check(value, path="$"):
    """JSON has texts as keys, and finite numbers."""
    if isinstance(value, dict):
        for key, item in value.items():
            if not isinstance(key, str):
                raise ValueError(f"{path}: the key {key!r} is no text; quote it")
            _check(item, f"{path}.{key}")
    elif isinstance(value, list):
        for index, item in enumerate(value):
            _check(item, f"{path}[{index}]")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{path}: {value} has no JSON")


def main():
    """Converts the file."""
    source, target = sys.argv[1:]
    with open(source, encoding="utf-8") as file:
        document = yaml.load(file, CoreSchemaLoader)
    _check(document)
    with open(target, "w", encoding="utf-8") as file:
        json.dump(document, file, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        file.write("\n")


if __name__ == "__main__":
    main()
