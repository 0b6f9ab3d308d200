# SPDX-License-Identifier: Apache-2.0
"""The part of JSON Schema (draft 7) that share/schema/ uses; a word that is not known here is an error."""
import re

KNOWN = {"$schema", "$ref", "title", "description", "default", "definitions", "type", "properties",
         "additionalProperties", "required", "anyOf", "const", "enum", "minimum", "exclusiveMinimum", "maximum",
         "minLength", "pattern", "items", "minItems", "maxItems"}
KINDS = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None),
         "integer": int, "number": (int, float)}


def is_type(value, name):
    if isinstance(value, bool):
        return name == "boolean"
    return isinstance(value, KINDS[name])


def own_problem(schema, value):
    """What the value itself breaks, without its members."""
    kinds = schema.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if kinds and not any(is_type(value, kind) for kind in kinds):
        return f"not of type {' or '.join(kinds)}"
    if "const" in schema and value != schema["const"]:
        return f"not {schema['const']!r}"
    if "enum" in schema and value not in schema["enum"]:
        return f"none of {schema['enum']}"
    if isinstance(value, str):
        if len(value) < schema.get("minLength", 0):
            return "too short"
        if not re.search(schema.get("pattern", ""), value):
            return f"does not match {schema['pattern']}"
    if isinstance(value, list) and not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
        return "too few or too many items"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if not schema.get("minimum", value) <= value <= schema.get("maximum", value):
            return "out of range"
        if value <= schema.get("exclusiveMinimum", value - 1):
            return "out of range"
    return None


def problems(schema, value, root=None, path="$"):
    """Every place at which the value breaks the schema, as "path: reason"."""
    root = schema if root is None else root
    if "$ref" in schema:
        return problems(root["definitions"][schema["$ref"].removeprefix("#/definitions/")], value, root, path)
    if set(schema) - KNOWN:
        raise ValueError(f"words that are not known here: {set(schema) - KNOWN}")
    if own := own_problem(schema, value):
        return [f"{path}: {own}: {str(value)[:80]}"]
    found = []
    if "anyOf" in schema:
        each = [problems(one, value, root, path) for one in schema["anyOf"]]
        if all(each):
            found += min(each, key=len)
    if isinstance(value, dict):
        named, others = schema.get("properties", {}), schema.get("additionalProperties", True)
        found += [f"{path}: missing key {key!r}" for key in schema.get("required", []) if key not in value]
        for key, one in value.items():
            if key in named:
                found += problems(named[key], one, root, f"{path}.{key}")
            elif others is False:
                found.append(f"{path}: unknown key {key!r}")
            elif others is not True:
                found += problems(others, one, root, f"{path}.{key}")
    if isinstance(value, list) and "items" in schema:
        for i, one in enumerate(value):
            found += problems(schema["items"], one, root, f"{path}[{i}]")
    return found


def is_closed(schema):
    """True if every object of the schema names all its keys, so that none comes unnoticed."""
    if isinstance(schema, list):
        return all(map(is_closed, schema))
    if not isinstance(schema, dict):
        return True
    if "properties" in schema and "additionalProperties" not in schema:
        return False
    return all(map(is_closed, schema.values()))
