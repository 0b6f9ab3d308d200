# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

Path("machine.toml").write_text("[machine]\nname = \"" + "x" * 200_000 + "\"\n")
