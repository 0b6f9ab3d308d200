# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

Path("plan.svg").symlink_to("program.exc")
