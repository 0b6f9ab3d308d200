# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

Path("program.exc").write_text("M48\nMETRIC,LZ\nT1C1.0\n%\nT1\nX" + "1" * 10_000_000 + "\nM30\n")
