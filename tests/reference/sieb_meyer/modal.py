# SPDX-License-Identifier: Apache-2.0
"""What a control remembers from line to line."""

import dataclasses
from typing import Optional

from .operations import Depth, Point


@dataclasses.dataclass
class Modal:
    tool: Optional[int] = None
    absolute: bool = True
    position: Optional[Point] = (0.0, 0.0)  # None: behind a section or a subprogram, not settled
    # T0 line and contour: "" nothing, "positioned" behind a T0 line, "routing" within a contour
    contour: str = ""
    motion: Optional[int] = None  # G1, G2, G3, G45 .. G50
    routed: bool = False  # the contour has a move
    compensation: Optional[str] = None
    feed_m_min: Optional[float] = None
    z_mm: Optional[float] = None
    k_mm: Optional[float] = None
    h_mm: Optional[float] = None
    board: bool = False  # G83, else G82
    slm: bool = False  # G71, else G70
    memory: Optional[int] = None
    peck: bool = False
    pulse: bool = False
    peck_values: tuple = ()
    pulse_values: tuple = ()
    # manual: I: routing and peck drilling keep their parameters apart; "the last settings remain active".
    r_mm: Optional[float] = None
    i_mm: Optional[float] = None
    j_mm: Optional[float] = None
    by_radius: Optional[bool] = None
    skip_labeled: Optional[bool] = None  # BLKD, NOBLKD
    board_pattern: Optional[bool] = None  # CAMA, NOCAMA

    def depth(self):
        """manual: chapter 11, and "Z": with depth control Z is the limit for lowering."""
        if self.slm:
            return Depth("surface", self.k_mm, self.z_mm, self.h_mm, self.memory)
        if self.board:
            return Depth("board", self.k_mm, self.z_mm, self.h_mm)
        return Depth("table", self.z_mm, None, self.h_mm)

    def cycle(self):
        if self.peck:
            return ("peck", self.peck_values)
        return ("pulse", self.pulse_values) if self.pulse else None
