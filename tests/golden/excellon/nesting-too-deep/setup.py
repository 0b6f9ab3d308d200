# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

Path("program.exc").write_text("M48\nMETRIC,LZ\nT1C1.0\n%\nT1\nM25\nX1.0Y2.0\n" + "M01\n" * 65 + "M08\nM30\n")
