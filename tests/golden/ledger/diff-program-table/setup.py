# SPDX-License-Identifier: Apache-2.0
import golden_ledger
import golden_table
entries = []
for error in (lambda x, y: (0, 0), golden_table.bowed):
    entry, _ = golden_ledger.offset(0, 0, "2026-11-19T02:00:00Z", subject="table")
    entry.update(kind="table", parameters=[], covariance=None)
    entries.append((entry, golden_table.table(error, low_mm=(-100, -100))))
golden_ledger.make("drill1.ledger", entries)
