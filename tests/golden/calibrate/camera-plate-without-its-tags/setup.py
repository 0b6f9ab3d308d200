# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from golden_pictures import discs

Path("looks").mkdir()
Path("looks/images.csv").write_text("file,x,y\na.png,100,80\n")
places = [(40 + 60 * column, 30 + 60 * row) for column in range(3) for row in range(3)]
Path("looks/a.png").write_bytes(discs(200, 180, places, 10))
