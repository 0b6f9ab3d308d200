# SPDX-License-Identifier: Apache-2.0
import golden_ledger
entries = [golden_ledger.offset(0, 0, "2026-11-19T02:00:00Z", verdict="measured", reason="")
           for _ in range(2)]
for entry, _ in entries:
    entry["kind"] = "self-test"
golden_ledger.make("drill1.ledger", entries)
