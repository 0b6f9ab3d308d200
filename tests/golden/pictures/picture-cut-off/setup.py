# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from golden_pictures import discs

data = discs(64, 64, [(31.5, 31.5)], 10)
Path("images/a.png").write_bytes(data[:len(data) // 2])
