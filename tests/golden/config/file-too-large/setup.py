# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

Path("machine.toml").write_text("# \n" * 1_000_000)
