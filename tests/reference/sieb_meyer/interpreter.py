# SPDX-License-Identifier: Apache-2.0
"""Sections and lines -> operations, in the order of the machine."""

import re

from . import geometry
from .contours import round_corners
from .modal import Modal
from .operations import Operation, Placement
from .reader import Refusal, codes, count, last, read, read_subprograms, value
from .routing import CAMERA, MOTIONS, Routing
from .sections import Section, build, layouts, placements

MAX_NESTING = 6  # manual: "M31": sections and calls together
MACHINE_FUNCTIONS = set(range(22, 28)) | set(range(34, 46)) | set(range(52, 56))
# CNC commands named by this manual that move no hole, and no end of a slot; the others stand in a manual of their own.
QUIET_COMMANDS = re.compile(r"FV1|NONIBO|NIB[0-9.]+|NOFA|NORA|NOSA|SPAV,[AMOT]|CHEK[TXSE,].*|MAPT[0-9.]+|SPEK|NOSPEK|[ADT]PEK,.*|PEKM,.*")
CORRECTIONS = re.compile(r"(CLEAR|SAVE|LOAD)[0-9]*|SPOP[12]?|SPISPI|REQCOMP|DELALL|SPOF[0-9]+")


def interpret(text, subprograms="", setting=None):
    """The operations of a program. Raises Refusal where the manual does not settle what a control does."""
    program = read(text, setting)
    machine = Interpreter(program, read_subprograms(subprograms))
    root = build(program.blocks, program.format, machine.layouts)
    operations = machine.run_copies(root) if root.offsets else machine.run(root.children)
    if machine.modal.contour == "routing":
        raise Refusal(root.line, "the program ends within a contour")
    return round_corners(operations)


class Interpreter(Routing):
    def __init__(self, program, subprograms):
        self.format = program.format
        self.diameters = program.diameters_mm
        self.subprograms = subprograms
        self.layouts = layouts(subprograms)
        self.modal = Modal()
        self.nesting = 0
        self.calls = []
        self.pair = None  # (code, point, line) of V1 .. V4 or G85 that waits for its second line

    # ---- sections and subprograms

    def run(self, children):
        operations = []
        for child in children:
            operations += self.run_section(child) if isinstance(child, Section) else self.run_block(child)
        if self.pair:
            raise Refusal(self.pair[2], "the second line is missing")
        return operations

    def run_section(self, section):
        if self.modal.contour or self.pair:
            raise Refusal(section.line, "a section begins within a contour or a row of holes")
        self.nest(section.line)
        operations = self.run_copies(section)
        self.nesting -= 1
        return operations

    def nest(self, line):
        self.nesting += 1
        if self.nesting > MAX_NESTING:
            raise Refusal(line, f"more than {MAX_NESTING} sections and calls within each other")

    def run_copies(self, section):
        """manual: 5.1: "the execution of the program is repeated (including all tool changes)": the lines
        are executed again for each copy, from the state that the copy before has left."""
        called = [block for block in section.offsets if block.zero is not None]
        if called:  # manual: chapter 6: "Calling the subprogram is counted as one nesting depth."
            self.nest(called[0].line)
            self.nesting -= 1
        result = []
        for copy in placements(section, self.format):
            operations = self.run_once(section)
            for operation in operations:
                # manual: V1: the direction of the rows depends on the axis version, by a figure.
                if operation.pattern and operation.pattern[0] == "V1" and not copy.is_translation:
                    raise Refusal(operation.line, "V1 in a section that is rotated or mirrored")
            result += [copy.apply(operation) for operation in operations]
            if not self.modal.absolute and any(block.zero != (0.0, 0.0) for block in called):
                raise Refusal(called[0].line, "a call of offset lines with coordinates under G91")
            if section.offsets:
                # manual: "G90": before an offset command the control switches to absolute.
                self.modal.absolute = True
        return result

    def run_once(self, section):
        self.modal.position = None
        operations = self.run(section.children)
        if self.modal.contour:
            raise Refusal(section.line, "the section ends within a contour")
        self.modal.position = None
        return operations

    def call(self, block):
        """manual: "M99": the coordinates of the call are added to those of the subprogram."""
        name = block.text
        if self.modal.contour or not self.modal.absolute:
            raise Refusal(block.line, "a call within a contour, or under G91")
        if name not in self.subprograms or name in self.calls:
            raise Refusal(block.line, f'subprogram is missing or calls itself: "{name}"')
        offset = (0.0, 0.0)
        if last(block, "X") or last(block, "Y"):
            offset = self.offset(block)
        root = build(self.subprograms[name], self.format, self.layouts)
        if root.offsets:
            raise Refusal(block.line, "offset lines without brackets in a subprogram")
        self.nest(block.line)
        self.calls.append(name)
        self.modal.position = None
        operations = self.run(root.children)
        operations += self.end_contour(block.line)
        self.modal.position = None
        self.calls.pop()
        self.nesting -= 1
        placement = Placement(1, 0, 0, 1, offset)
        return [placement.apply(operation) for operation in operations]

    def offset(self, block):
        if not (last(block, "X") and last(block, "Y")):
            raise Refusal(block.line, "X or Y is missing")
        return tuple(self.value(block, axis) for axis in "XY")

    # ---- lines

    def run_block(self, block):
        modal = self.modal
        if block.labeled:
            if modal.skip_labeled is None:
                raise Refusal(block.line, "/ depends on BLKD or NOBLKD, which the program does not set")
            if modal.skip_labeled:
                return []
        if block.command in ("M47", "M49", "M75", "M76", "G35", "G39"):
            return self.run_command(block)
        if self.pair:
            return self.end_pair(block)
        unread = {word.letter for word in block.words} - {"G", "M", "T", "V", "X", "Y"}
        g = codes(block, "G")
        placed = last(block, "X") is not None or last(block, "Y") is not None
        self.check_line(block, g, placed)
        before = modal.depth()
        if "F" in unread:
            modal.feed_m_min = self.value(block, "F")
            unread.discard("F")
        self.set_tool(block)
        self.set_planes(block, g, unread)
        self.set_modes(block, g)
        t0 = 0 in codes(block, "T")
        motion = next((code for code in reversed(g) if code in MOTIONS), None)
        if self.format == 1000 and modal.contour == "routing" and placed and motion is None and not t0:
            raise Refusal(block.line, "Format 1000 needs the routing function in every block")
        routes = placed and not t0 and (motion is not None or modal.contour in ("routing", "left"))
        self.set_parameters(block, g, routes, motion, unread)
        if unread:
            raise Refusal(block.line, f"{', '.join(sorted(unread))}: no meaning in this line")
        if block.command == "M99":
            return self.call(block)
        if t0:
            if motion is not None or block.command or codes(block, "V"):
                raise Refusal(block.line, "T0 and a working command on one line")
            return self.run_t0(block, placed)
        if motion is not None and not placed:
            raise Refusal(block.line, "a routing function without coordinates")
        if routes:
            return self.route(block, motion, g, before)
        if not placed:
            if block.command or codes(block, "V"):
                raise Refusal(block.line, "coordinates are missing")
            return []
        if any(code in (11, 43, 6) or code in (40, 41, 42) for code in g):
            raise Refusal(block.line, "a routing condition without a routing function")
        return self.drill(block, g)

    def value(self, block, letter):
        return value(last(block, letter), block.line, self.format)

    def positive(self, block, letter):
        result = self.value(block, letter)
        if result < 0:
            raise Refusal(block.line, f"only positive values are allowed for {letter}")
        return result

    def run_command(self, block):
        """Commands with text that neither drill nor rout."""
        if block.words:
            raise Refusal(block.line, f"{block.command} must stand in a line of its own")
        if self.modal.contour == "routing" and block.command != "M49":
            raise Refusal(block.line, f"{block.command} within a contour")
        text = block.text.replace(" ", "")
        if block.command == "G39" and not CORRECTIONS.fullmatch(text):
            raise Refusal(block.line, f'no command of G39: "{text}"')
        if block.command == "M49":
            if text in ("BLKD", "NOBLKD"):
                self.modal.skip_labeled = text == "BLKD"
            elif text in ("CAMA", "NOCAMA"):
                self.modal.board_pattern = text == "CAMA"
            elif not QUIET_COMMANDS.fullmatch(text):
                raise Refusal(block.line, f'the effect of a CNC command is not in this manual: "{text}"')
        return []

    def check_line(self, block, g, placed):
        """Commands whose effect is not settled here, or that stand where the manual forbids them."""
        routing = self.modal.contour == "routing"
        for code in codes(block, "M"):
            if code == 58 or code == 93:
                raise Refusal(block.line, f"M{code} depends on settings of the control")
            if code in MACHINE_FUNCTIONS and (placed or routing):
                raise Refusal(block.line, "a machine function must stand alone, outside of contours")
            if code == 20 and 0 not in codes(block, "T") and (routing or MOTIONS & set(g)):
                raise Refusal(block.line, "M20 within a contour")
            if code in (56, 57) and (not placed or routing or len(block.words) != 3):
                raise Refusal(block.line, "M56 and M57 need X and Y and nothing else")
        if {76, 77} & set(g):
            raise Refusal(block.line, "G76 and G77 are named but not described by the manual")
        camera = CAMERA & set(g)
        if camera:
            # manual: chapter 9, "Note": no other commands after a camera command in the line.
            word = block.words[-1]
            if word.letter != "G" or int(word.digits) not in CAMERA or block.command or self.modal.contour:
                raise Refusal(block.line, "a camera command must end its line, outside of contours")
            if placed != bool(camera & {32, 33, 36}):
                raise Refusal(block.line, "coordinates are missing, or have no meaning, with a camera command")
        if routing and (last(block, "L") or {70, 71, 72, 73, 74, 75, 78, 79} & set(g)):
            raise Refusal(block.line, "surface detection within a contour")

    # ---- states

    def set_tool(self, block):
        tools = [tool for tool in codes(block, "T") if tool > 0]
        if not tools:
            return
        if self.modal.contour == "routing":
            raise Refusal(block.line, "a tool change within a contour")
        if 0 not in codes(block, "T") and self.modal.contour != "left":
            self.modal.contour = ""  # the T0 line before prevented a stroke, it begins no contour
        if tools[-1] > {1000: 15, 3000: 30, 5000: 99}[self.format]:
            raise Refusal(block.line, "no such tool in this format")
        self.modal.tool = tools[-1]

    def set_planes(self, block, g, unread):
        modal = self.modal
        if "H" in unread:
            modal.h_mm = self.positive(block, "H")
        if 71 in g:
            if "K" in unread and "Z" in unread:
                raise Refusal(block.line, "G71 with K and Z")
            # manual: "G74", examples: "G71Z.4: relative working plane = 0.4 mm".
            if "K" in unread or "Z" in unread:
                modal.k_mm = self.value(block, "K" if "K" in unread else "Z")
        else:
            if "Z" in unread:
                modal.z_mm = self.positive(block, "Z")
            if "K" in unread:
                if modal.slm:
                    raise Refusal(block.line, "K under G71 without G71 in the line is not settled")
                modal.k_mm = self.positive(block, "K")
        unread -= {"H", "K", "Z"}
        if "L" in unread:
            number = count(last(block, "L"), block.line)
            if len(block.words) == 1:
                modal.memory = number
            elif not {73, 74} & set(g):
                raise Refusal(block.line, "L must stand in a separate block, or with G73 or G74")
            unread.discard("L")
        elif 74 in g:
            raise Refusal(block.line, "G74 needs L")

    def set_modes(self, block, g):
        """G80 .. G91, G70, G71, G40 .. G42; the last of a group counts (manual: A.3)."""
        modal = self.modal
        if self.format == 1000:
            modal.absolute = True  # manual: appendix B: G91 must be programmed in every block
        for code in g:
            if code in (90, 91):
                modal.absolute = code == 90
            elif code in (82, 83):
                if modal.slm:
                    raise Refusal(block.line, "G82 or G83 under G71 is not settled")
                modal.board = code == 83
            elif code in (70, 71):
                if modal.board and code == 71:
                    raise Refusal(block.line, "G71 under G83 is not settled")
                if modal.contour:
                    raise Refusal(block.line, "G70 or G71 within a contour")
                modal.slm = code == 71
            elif code in (80, 81):
                modal.peck = code == 81
            elif code in (88, 89):
                modal.pulse = code == 89
            elif code in (40, 41, 42):
                modal.compensation = {40: None, 41: "left", 42: "right"}[code]
        if modal.peck and modal.pulse:
            raise Refusal(block.line, "peck drilling and pulse drilling at the same time")
        if modal.board and not modal.slm and modal.k_mm is not None and modal.k_mm < 0:
            raise Refusal(block.line, "the K of G71 is negative and G83 has no K of its own")

    def set_parameters(self, block, g, routes, motion, unread):
        """I, J, R, W, P, E go to routing, peck drilling or pulse drilling, D to the corner."""
        modal = self.modal
        if routes:
            names = unread & {"I", "J", "R"}
            if "R" in names and len(names) > 1:
                raise Refusal(block.line, "R together with I or J")
            if names:
                modal.by_radius = "R" in names
            if "R" in names:
                modal.r_mm = self.value(block, "R")
            if "I" in names:
                modal.i_mm = self.value(block, "I")
            if "J" in names:
                modal.j_mm = self.value(block, "J")
            unread -= {"I", "J", "R", "D"}
        elif 84 in g:
            unread.discard("R")
        elif modal.contour != "routing":
            if modal.peck:
                modal.peck_values = self.keep(block, modal.peck_values, unread & set("IJPW"))
                unread -= set("IJPW")
            elif modal.pulse:
                modal.pulse_values = self.keep(block, modal.pulse_values, unread & set("IJER"))
                unread -= set("IJER")

    def keep(self, block, values, letters):
        result = dict(values)
        for letter in letters:
            result[letter] = count(last(block, letter), block.line) if letter in "PWE" else self.positive(block, letter)
        return tuple(sorted(result.items()))

    # ---- work

    def target(self, block, complete):
        """Where the line's X and Y are.

        manual: G1 .. G3: a coordinate that is missing keeps its last value. For holes the manual always
        programs both: `complete`.
        """
        position = self.modal.position
        result = []
        for axis, index in (("X", 0), ("Y", 1)):
            missing = last(block, axis) is None
            if missing and complete:
                raise Refusal(block.line, f"{axis} is missing")
            if (missing or not self.modal.absolute) and position is None:
                raise Refusal(block.line, "no last coordinate: the line follows the begin or the end of a section")
            programmed = 0.0 if missing else self.value(block, axis)
            if missing or not self.modal.absolute:
                programmed += position[index]
            result.append(programmed)
        return tuple(result)

    def operation(self, kind, line, **fields):
        return Operation(kind, line, self.modal.tool, self.modal.depth(), **fields)

    def drill(self, block, g):
        """A line with coordinates outside of contours. manual: chapter 2."""
        modal = self.modal
        line = block.line
        at = self.target(block, True)
        kinds = [code for code in g if code in (32, 33, 36, 73, 78, 79, 84, 85)]
        pattern = codes(block, "V")
        if len(kinds) + len(pattern) + (block.command != "") > 1:
            raise Refusal(line, "two working commands on one line")
        if {56, 57} & set(codes(block, "M")):
            return []  # the start of an area for check holes
        modal.contour = ""
        modal.position = at
        if block.command:
            if not block.text:
                raise Refusal(line, f"{block.command} without a text")
            direction = {"M97": (1.0, 0.0), "M98": (0.0, 1.0)}[block.command]
            return [self.operation("text", line, at=at, direction=direction, string=block.text)]
        if pattern or 85 in kinds:
            self.pair = (f"V{pattern[0]}" if pattern else "G85", at, line)
            return []
        if 84 in kinds:
            radius = self.value(block, "R") if last(block, "R") else 0
            if radius < 0.5:
                raise Refusal(line, "G84 needs R, at least 0.5 mm")
            # manual: G84, "Example": the tool's diameter is not larger than the radius.
            if self.diameters.get(modal.tool, 0) > radius:
                raise Refusal(line, "the tool is larger than the radius of G84")
            return [self.operation("nibble_circle", line, center=at, radius=radius)]
        hole = self.operation("hole", line, at=at, cycle=modal.cycle())
        if not kinds:
            return [hole]
        kind = "probe" if kinds[0] > 70 else "measure"
        operations = [Operation(kind, line, None, at=at, string=f"G{kinds[0]}")]
        if kinds[0] == 36:
            if modal.board_pattern is None:
                raise Refusal(line, "G36 depends on CAMA or NOCAMA, which the program does not set")
            if not modal.board_pattern:
                operations.append(hole)  # manual: "G36": NOCAMA measures, then drills
        return operations

    def end_pair(self, block):
        code, first, _ = self.pair
        if block.command or any(word.letter not in "XYW" for word in block.words):
            raise Refusal(block.line, f"only X, Y and W may end {code}")
        self.modal.position = first
        end = self.target(block, True)
        self.modal.position = end
        self.pair = None
        w = count(last(block, "W"), block.line) if last(block, "W") else None
        if code == "G85":
            if w is not None or first == end:
                raise Refusal(block.line, "a slot needs two points and no W")
            return [self.operation("nibble_slot", block.line, start=first, end=end)]
        row = {"V1": geometry.dual_row, "V2": geometry.single_row, "V3": geometry.quadruple_row,
               "V4": geometry.circle_row}[code]
        if first == end:
            raise Refusal(block.line, f"{code} needs two points")
        holes = row(first, end, w, block.line)
        # manual: V2 counts from the first to the last hole; no order is given for the others.
        pattern = None if code == "V2" else (code, block.line, len(holes))
        return [self.operation("hole", block.line, at=hole, cycle=self.modal.cycle(), pattern=pattern) for hole in holes]
