# SPDX-License-Identifier: Apache-2.0
"""Step and repeat sections: M25, pattern, M01, M02 blocks, M08. Section "Step and Repeat Commands"."""
from dataclasses import dataclass
from fractions import Fraction
import itertools

from .model import Placement, Refused
from .words import integer


@dataclass
class Copy:
    """One placement of a level, with the tool that its M02 block selects, if any."""

    placement: Placement
    tool_block: str | None = None


@dataclass
class Section:
    """Lines of the pattern, the levels of copies from the innermost, and whether M08M30 ends the program."""

    pattern: list
    levels: list
    end_line: int
    ends_program: bool

    def copies(self):
        """(placement, tool blocks, path) of each copy in machine order: a level repeats all that its inner levels make."""
        for chosen in itertools.product(*(tuple(enumerate(level)) for level in reversed(self.levels))):
            placement = Placement()
            for _, copy in chosen:
                placement = placement.after(copy.placement)
            # A level's M02 block is read once, in front of the first of the copies that its inner levels make.
            tool_blocks = [copy.tool_block for i, (_, copy) in enumerate(chosen)
                           if copy.tool_block and not any(index for index, _ in chosen[i + 1:])]
            yield placement, tool_blocks, tuple(index for index, _ in chosen)


class Level:
    """M02 blocks of one level: offsets add up, mirrors and swap hold for their own block."""

    def __init__(self):
        self.copies = [Copy(Placement())]
        self.offset = (Fraction(0), Fraction(0))
        self.needs_end = False  # an M02 with coordinates wants a bare M02 at the end
        self.closed = False

    def add(self, words, repeats, interpreter, line):
        if self.closed:
            raise Refused(line, 'M02 after the bare M02 of its level')
        if not words:
            if len(self.copies) == 1:
                raise Refused(line, 'a bare M02 that ends nothing')
            self.closed = True
            return
        axes, codes, tool = self.parts(words, line)
        dx, dy = interpreter.spacing(axes, line)
        if tool and repeats is not None:
            raise Refused(line, 'a tool in a repeat block')
        for _ in range(1 if repeats is None else repeats):
            self.offset = (self.offset[0] + dx, self.offset[1] + dy)
            placement = Placement.of('80' in codes, '90' in codes, '70' in codes, *self.offset)
            self.copies.append(Copy(placement, tool))
        self.needs_end = repeats is None

    @staticmethod
    def parts(words, line):
        """(X and Y words, codes of mirrors and swap, tool block) after M02."""
        axes = [word for word in words if word[0] in 'XY']
        codes = [text for letter, text in words if letter == 'M']
        tools = [text for letter, text in words if letter == 'T']
        if len(axes) + len(codes) + len(tools) != len(words) or words[:len(axes)] != axes or len(tools) > 1:
            raise Refused(line, 'M02 with other words than X, Y, M70, M80, M90, T')
        if len(set(codes)) != len(codes) or not set(codes) <= {'70', '80', '90'}:
            raise Refused(line, 'M02 with codes other than M70, M80, M90')
        if '70' in codes[:-1]:
            raise Refused(line, 'M70 before a mirror: the manual always mirrors first')
        return axes, codes, 'T' + tools[0] if tools else None

    def finish(self, line):
        """The level's copies; refuses an M02 chain without its bare M02."""
        if self.needs_end and not self.closed:
            raise Refused(line, 'the last M02 with coordinates wants a bare M02')
        return self.copies


def read_section(cursor, interpreter, line):
    """Reads from after M25 up to M08."""
    pattern = []
    while True:
        at, text = cursor.next_block(line)
        code = interpreter.section_code(text)
        if code == 'M01':
            break
        if code in ('M25', 'M02', 'M08', 'R'):
            raise Refused(at, f'"{text}" inside a pattern')
        pattern.append((at, text))
    levels, level, stated = [], Level(), False
    while True:
        at, text = cursor.next_block(line)
        code = interpreter.section_code(text)
        if code in ('M01', 'M08', 'M08M30'):
            if len(level.copies) > 1 or (code != 'M01' and levels):
                levels.append(level.finish(at))
            else:
                raise Refused(at, 'a level without M02')
            level = Level()
            if code != 'M01':
                return Section(pattern, levels, at, code == 'M08M30')
        elif code in ('M02', 'R'):
            words = interpreter.words(text, at)
            repeats = None
            if code == 'R':
                repeats = integer(words.pop(0)[1], at, 'R', 4)
                if not repeats or len(words) == 1:
                    raise Refused(at, 'R#M02 without a number or an offset')
            level.add(words[1:], repeats, interpreter, at)
        else:
            raise Refused(at, f'"{text}" between M01 and M08')

