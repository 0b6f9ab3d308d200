# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

lines = ["%%5000", "G71"] + [f"X{x}.Y10.G73" for x in range(101)]
Path("program.s5").write_text("\n".join(lines) + "\n")
