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


def checked(document, repository):
    """The document, once its schema has been asked."""
    schema = Path(repository) / "share/schema" / f"{document['facts']}.schema.json"
    found = problems(json.loads(schema.read_text()), document)
    assert not found, found[:10]
    return document
