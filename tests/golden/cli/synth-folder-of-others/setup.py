# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from golden_pictures import discs

Path("pictures").mkdir()
Path("pictures/0000.png").write_bytes(discs(16, 16, [], 0))
