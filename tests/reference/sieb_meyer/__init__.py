# SPDX-License-Identifier: Apache-2.0
"""A second reading of SIEB & MEYER part programs (Format 1000, 3000 and 5000).

Written from "CNC 8x.00 SIEB & MEYER - Command Set" alone, by someone who had not seen panelcal's
own interpreter, so that the two can check each other. `interpret(text)` returns the operations that a
control executes, in the order in which it executes them, in mm, in the program's own frame with axis
version FV1 (x right, y up). What the manual leaves open is refused with `Refusal`, never guessed;
the comments "manual: ..." name the section that a rule comes from.
"""

from .interpreter import interpret
from .numbers import Setting
from .operations import Depth, Operation
from .reader import Program, Refusal, read

__all__ = ["Depth", "Operation", "Program", "Refusal", "Setting", "interpret", "read"]
