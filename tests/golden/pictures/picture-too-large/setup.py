# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from golden_pictures import png

Path("images/a.png").write_bytes(png(64, 64, [bytes(64)] * 64, claims=(60000, 60000)))
