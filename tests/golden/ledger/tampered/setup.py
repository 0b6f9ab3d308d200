# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import golden_ledger

golden_ledger.two_nights().close()
ledger = Path("drill1.ledger")
ledger.write_bytes(ledger.read_bytes().replace(b"50.0041", b"50.0001"))
