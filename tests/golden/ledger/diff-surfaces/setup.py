# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import golden_ledger


def surface(offset, time, file):
    entry, _ = golden_ledger.offset(0, 0, time, subject="table", kind="surface",
                                    parameters=[{"name": "offset", "value": offset, "unit": "mm"}],
                                    covariance=[[1e-06]])
    return entry, Path(file).read_text()


golden_ledger.make("drill1.ledger", [surface(1.6, "2026-11-19T02:00:00Z", "before.json"),
                                     surface(1.61, "2026-11-20T02:00:00Z", "after.json")])
