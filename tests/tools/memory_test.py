#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Peak memory of a step and repeat job does not depend on the number of holes."""

import sys
import tempfile
from pathlib import Path

ALLOWED_MIB = 2  # what an allocator and page cache may differ by; a hole kept would cost 50 MiB


def main():
    panelcal, root = sys.argv[1:]
    sys.path.insert(0, str(Path(root) / "tests/bench"))
    from repeat_memory import run

    with tempfile.TemporaryDirectory() as folder:
        small, _, _ = run(panelcal, folder, 10**4)
        large, _, _ = run(panelcal, folder, 10**6)
    print(f"peak {small:.1f} MiB for 1e4 holes, {large:.1f} MiB for 1e6")
    assert large - small < ALLOWED_MIB


if __name__ == "__main__":
    main()
