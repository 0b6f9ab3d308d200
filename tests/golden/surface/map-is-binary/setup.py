# SPDX-License-Identifier: Apache-2.0
import pathlib
pathlib.Path("map.json").write_bytes(bytes(range(256)))
