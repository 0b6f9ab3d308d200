# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from golden_pictures import discs

Path("a.png").write_bytes(discs(64, 64, [(32, 32)], 10))
Path("b.png").write_bytes(discs(64, 64, [(22, 32)], 10))
Path("c.png").write_bytes(discs(64, 64, [], 0))
