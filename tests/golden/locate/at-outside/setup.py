# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from golden_pictures import discs

Path("a.png").write_bytes(discs(64, 64, [], 0))
