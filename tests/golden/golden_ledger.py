# SPDX-License-Identifier: Apache-2.0
"""Makes ledgers for cases, from docs/decisions/ledger.md and without panelcal."""
import hashlib
import json
import re
import sqlite3

from golden_source import source_text


def sha256(text):
    return hashlib.sha256(text.encode()).hexdigest()


def offset(x, y, time, subject="spindle 1 station 1", verdict="installed", reason="gates passed",
           **more):
    """An entry on a spindle-camera offset and its result."""
    entry = {
        "time": time,
        "machine": "drill 1",
        "kind": "spindle-camera",
        "subject": subject,
        "verdict": verdict,
        "reason": reason,
        "asked_by": "timer",
        "software": "panelcal 0.1.0",
        "temperature_degC": 21.5,
        "inputs": [{"name": "coupon.png", "sha256": sha256("coupon"), "bytes": 6}],
        "parameters": [{"name": "offset_x", "value": x, "unit": "mm"},
                       {"name": "offset_y", "value": y, "unit": "mm"}],
        "covariance": [[1e-06, 0], [0, 4e-06]],
        "replaces": None,
        "restores": None,
    }
    entry.update(more)
    return entry, json.dumps({"kind": "spindle-camera", "offset_mm": [x, y]}, indent=1)


def make(path, entries):
    header = source_text("schema.h", "kLedgerSchema")
    schema = re.search(r'kLedgerSchema = R"sql\((.*?)\)sql"', header, re.S).group(1)
    database = sqlite3.connect(path)
    database.executescript(schema)
    database.execute(f"PRAGMA application_id={int.from_bytes(b'PCAL', 'big')}")
    database.execute("PRAGMA user_version=1")
    previous = 64 * "0"
    for number, (entry, result) in enumerate(entries, 1):
        entry = {"panelcal": "ledger-entry", "id": number, **entry,
                 "result_sha256": sha256(result), "result_bytes": len(result)}
        content = json.dumps(entry, separators=(",", ":"))
        digest = sha256(previous + "\n" + content)
        database.execute("INSERT INTO ledger_entry(id, previous, hash, content, result) "
                         "VALUES (?, ?, ?, ?, ?)", (number, previous, digest, content, result))
        previous = digest
    database.commit()
    return database


def two_nights(path="drill1.ledger"):
    """Two installed offsets of one spindle, a refused one, and another spindle's."""
    return make(path, [
        offset(50.0, -3.0, "2026-11-19T02:00:00Z"),
        offset(50.0041, -3.0002, "2026-11-20T02:00:00Z", replaces=1),
        offset(50.3, -2.1, "2026-11-21T02:00:00Z", verdict="refused",
               reason="change 946 um, limit 50 um"),
        offset(12.5, 4.0, "2026-11-21T02:05:00Z", subject="spindle 2 station 1"),
        ({**offset(0, 0, "2026-11-21T02:10:00Z", subject="zoom 1", verdict="measured", reason="")[0],
          "kind": "camera"}, "{}"),
    ])
