# SPDX-License-Identifier: Apache-2.0
"""Lines -> nested program sections with their offset lines. manual: chapter 5."""

import dataclasses

from .operations import MATRICES, Placement
from .reader import Block, Refusal, codes, count, last, value

OFFSETS = frozenset({50, 60, 70, 80, 90})


@dataclasses.dataclass
class Section:
    line: int
    children: list = dataclasses.field(default_factory=list)  # Block or Section
    offsets: list = dataclasses.field(default_factory=list)  # Block


def layouts(subprograms):
    """The subprograms of offset lines alone. manual: chapter 6: "Mixing working blocks (drilling/routing)
    and offset blocks in subroutines is not allowed", so that one may have either."""
    return {name: blocks for name, blocks in subprograms.items()
            if blocks and all(OFFSETS & set(codes(block, "M")) for block in blocks)}


def build(blocks, format_, layouts_=None):
    """The root section of a program or subprogram.

    manual: "M31", "M30": the coordinates of both lines belong to the section. Format 1000 has M30 but
    no M31: there a section begins with the program or behind the last M30.
    """
    root = Section(1)
    implied = Section(1)
    stack = [root, implied] if format_ == 1000 else [root]
    for block in blocks:
        marks = codes(block, "M")
        opened, closed = marks.count(31), marks.count(30)
        if block.labeled and (opened or closed or OFFSETS & set(marks)):
            raise Refusal(block.line, "/ on a line that opens, places or closes a section is not settled")
        layout = (layouts_ or {}).get(block.text) if block.command == "M99" else None
        if opened and (layout or OFFSETS & set(marks)):
            raise Refusal(block.line, "M31 on an offset line")
        if OFFSETS & set(marks):
            add_offset(stack, block, format_)
        elif layout:
            add_layout(stack, block, layout, format_)
        else:
            rest = Block(block.line, [w for w in block.words if not (w.letter == "M" and int(w.digits) in (30, 31))],
                         block.command, block.text, block.labeled)
            if (opened or rest.words or rest.command) and stack[-1].offsets:
                raise Refusal(block.line, "a working line stands behind the offset lines of its section")
            for _ in range(opened):
                section = Section(block.line)
                stack[-1].children.append(section)
                stack.append(section)
            if rest.words or rest.command:
                stack[-1].children.append(rest)
        for _ in range(closed):
            close(stack, block, format_)
    if format_ == 1000:
        root.children.append(stack.pop())
    if len(stack) != 1:
        raise Refusal(stack[-1].line, "M31 without M30")
    return root


def close(stack, block, format_):
    if format_ == 1000:
        if not stack[-1].children:
            raise Refusal(block.line, "M30 without lines before it")
        stack[0].children.append(stack.pop())
        stack.append(Section(block.line))
    elif len(stack) == 1:
        raise Refusal(block.line, "M30 without M31")
    else:
        stack.pop()


def add_offset(stack, block, format_):
    section = stack[-1]
    # manual: "Avoid program un-bracketed program section": an offset behind closed sections could mean
    # all of them or the lines since.
    if format_ != 1000 and len(stack) == 1 and any(isinstance(child, Section) for child in section.children):
        raise Refusal(block.line, "an offset line without brackets behind a bracketed section")
    section.offsets.append(block)


def add_layout(stack, call, layout, format_):
    """manual: "M99": the coordinates of the call are "added to all coordinates of the subprogram"."""
    if call.labeled or any(word.letter not in "XYM" or (word.letter == "M" and int(word.digits) != 30)
                           for word in call.words):
        raise Refusal(call.line, "only X, Y and M30 may stand before the call of offset lines")
    axes = [last(call, axis) for axis in "XY"]
    if axes.count(None) == 1:
        raise Refusal(call.line, "X or Y is missing")
    zero = (0.0, 0.0) if axes[0] is None else tuple(value(axis, call.line, format_) for axis in axes)
    for block in layout:
        if {30, 31} & set(codes(block, "M")):
            raise Refusal(block.line, "a bracket in a subprogram of offset lines")
        add_offset(stack, dataclasses.replace(block, zero=zero), format_)


def placements(section, format_):
    """The copies that a section's offset lines ask for; without any: one, where it is programmed."""
    if not section.offsets:
        return [Placement(1, 0, 0, 1, (0.0, 0.0))]
    if not section.children:
        raise Refusal(section.line, "offset lines without a section")
    result = []
    row = None  # the line with M50V2 that waits for its end
    for block in section.offsets:
        marks = frozenset(codes(block, "M")) & OFFSETS
        check_offset(block, marks)
        offset = tuple(value(last(block, axis), block.line, format_) for axis in "XY")
        zero = block.zero or (0.0, 0.0)
        w = last(block, "W")
        if row is not None:
            result += pattern_row(block, marks, offset, w, zero)
            row = None
        elif last(block, "V") is not None:
            if marks != {50} or offset != (0.0, 0.0) or w is not None:
                raise Refusal(block.line, "the first line of a pattern row must be X0Y0M50V2")
            if len(section.offsets) != 2:
                raise Refusal(block.line, "a section with a pattern row and further offsets is not settled")
            row = block
        elif w is not None:
            raise Refusal(block.line, "W without M50V2 on the line before")
        else:
            result.append(Placement(*MATRICES[marks], (zero[0] + offset[0], zero[1] + offset[1])))
    if row is not None:
        raise Refusal(row.line, "M50V2 without its end line")
    return result


def pattern_row(block, marks, offset, w, zero):
    """manual: "M50V2": W copies, evenly from the zero point to the last one."""
    if marks != {50} or w is None or last(block, "V") is not None or count(w, block.line) < 2:
        raise Refusal(block.line, "the end of a pattern row must be X..Y..M50W.., W two or more")
    n = count(w, block.line)
    return [Placement(1, 0, 0, 1, (zero[0] + offset[0] * k / (n - 1), zero[1] + offset[1] * k / (n - 1)))
            for k in range(n)]


def check_offset(block, marks):
    if marks not in MATRICES:
        raise Refusal(block.line, "this combination of offset commands is not in the manual")
    if block.command or last(block, "X") is None or last(block, "Y") is None:
        raise Refusal(block.line, "an offset line must have X and Y, and no text")
    for word in block.words:
        allowed = word.letter in "XYW" or (word.letter == "V" and int(word.digits) == 2)
        if not allowed and not (word.letter == "M" and int(word.digits) in OFFSETS | {30, 92}):
            raise Refusal(block.line, f"{word.letter}{word.digits} on an offset line")
