# SPDX-License-Identifier: Apache-2.0
"""Documents of facts in tests: read from pages, and held against their schemas."""
import json
from pathlib import Path

from json_schema import problems

MARK = '<script type="application/json" id="facts">'


def in_page(path):
    """The document that a page shows."""
    text = Path(path).read_text(encoding="utf-8")
    assert text.count(MARK) == 1, path
    return json.loads(text.split(MARK)[1].split("</script>")[0])


def documents_in(value):
    """The document, and those within it."""
    if isinstance(value, dict):
        return ([value] if "facts" in value else []) + [one for part in value.values() for one in documents_in(part)]
    return [one for part in value for one in documents_in(part)] if isinstance(value, list) else []


def checked(document, repository):
    """The document, once the schemas of it and of those within it have been asked."""
    for one in documents_in(document):
        schema = Path(repository) / "share/schema" / f"{one['facts']}.schema.json"
        found = problems(json.loads(schema.read_text()), one)
        assert not found, found[:10]
    return document
