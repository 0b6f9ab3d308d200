# SPDX-License-Identifier: Apache-2.0
"""Execution of a part program, block by block."""
from dataclasses import dataclass, replace
from fractions import Fraction
import re

from .drilling import Drilling
from .model import HERE, Operation, Placement, Refused
from .routing import DEFAULT_TABLE_FEED_MM_S, Routing
from .sections import read_section
from .setup import Setup
from .words import NumberFormat, split_words

# Section "List of Equivalent Format One Commands".
FORMAT_TWO_OF_ONE = {('M', '02'): ('M', '00'), ('M', '24'): ('M', '01'), ('M', '26'): ('M', '02'),
                     ('M', '01'): ('M', '06'), ('M', '27'): ('M', '08'), ('M', '00'): ('M', '09'),
                     ('M', '23'): ('M', '70'), ('M', '70'): ('M', '72'), ('M', '21'): ('M', '80'),
                     ('M', '22'): ('M', '90'), ('G', '81'): ('G', '05')}
NOT_IN_FORMAT_ONE = {('M', code) for code in ('06', '08', '09', '72', '80', '90')}
# Blocks that change no position: tip check, peck drilling, reference scaling off, spindle groups.
QUIET = re.compile(r'M96,([0-9]+|OFF)|M18|M61|M62|M63|M19(,[0-9]+)?')


UNTOOLED = ('position', 'stop', 'dwell', 'message')


def numbered(text):
    """[(line number, line)] without spaces and empty lines at the end."""
    return [(number, line.rstrip()) for number, line in enumerate(text.rstrip().split('\n'), 1)]


@dataclass
class Program:
    """Operations in machine order and the tools that the program states."""

    operations: list
    tools: dict


class Cursor:
    """Position in a list of (line number, text)."""

    def __init__(self, lines):
        self.lines = lines
        self.at = 0

    def more(self):
        return self.at < len(self.lines)

    def take(self):
        self.at += 1
        return self.lines[self.at - 1]

    def line(self):
        """Number of the line taken last."""
        return self.lines[self.at - 1][0]

    def next_block(self, line):
        """The next block that is not empty."""
        while self.more():
            at, text = self.take()
            if text:
                return at, text
        raise Refused(line, 'the program ends inside a command')


class Interpreter(Setup, Drilling, Routing):
    """State of the control. `subprograms` gives the texts of M99 patterns by name."""

    def __init__(self, subprograms=None):
        self.subprograms = subprograms or {}
        self.format = NumberFormat()
        self.format_one = False  # the manual's examples without FMAT are in Format 2
        self.delete_blocks = None
        self.header_lines = None
        self.tools, self.compensation_mm = {}, {}
        self.tool, self.tool_index = None, None
        self.override = False  # G07: feeds and speeds of the body hold
        self.operations = []
        self.incremental = False
        self.position = [Fraction(0), Fraction(0)]
        self.known = [False, False]  # an axis that a block may leave out in absolute mode
        self.accumulated = True  # the position that an incremental block may start from
        self.moved = False
        self.last_hole = False
        self.pattern, self.pattern_offset = None, None
        self.text_offset = [Fraction(0), Fraction(0)]
        self.zero = (Fraction(0), Fraction(0))
        self.placement, self.in_section, self.path = HERE, False, None
        self.in_subprogram, self.file = False, None
        self.routing, self.plunged, self.interpolation = False, False, None
        self.side, self.arc = None, None
        self.table_feed_mm_s = DEFAULT_TABLE_FEED_MM_S
        # "Repeat of all the commands", "identical patterns": a copy's feed is unclear where the pass before left another.
        self.feed_unclear = False
        self.cursor, self.ended = None, False

    def run(self, text):
        """Executes a whole program."""
        lines = numbered(text)
        cursor = Cursor(lines)
        self.read_header(cursor)
        self.execute(cursor)
        if self.plunged:
            raise Refused(len(lines), 'the program ends in the rout position')
        return Program(self.operations, self.tools)

    def read_header(self, cursor):
        """M48 up to M95 or %, if the program has a header."""
        if not cursor.lines or cursor.lines[0][1] != 'M48':
            return
        self.header_lines = set()
        cursor.take()
        while True:
            line, text = cursor.next_block(1)
            if text in ('%', 'M95'):
                return
            if text.startswith(';'):
                continue
            self.header_lines.add(text)
            if text.startswith('T') and text[1:2].isdigit():
                self.tool_command(text, line, in_header=True)
            elif text.startswith('Z'):
                self.mean_depth(text, line)
            elif not self.setup_command(text, line):
                raise Refused(line, f'"{text}" in a header')

    def mean_depth(self, text, line):
        """Z+# or Z-#. Z alone and ZA, ZC, ZS set zeros, which the part program chapter does not explain."""
        if not re.fullmatch(r'Z[+-]?[0-9.]+', text):
            raise Refused(line, f'"{text}" in a header')
        self.format.length_mm(text[1:], line)

    def execute(self, cursor):
        outer, self.cursor = self.cursor, cursor
        while cursor.more() and not self.ended:
            line, text = cursor.take()
            if text:
                self.block(text, line)
        self.cursor = outer

    def block(self, text, line):
        if text.startswith('/') and text != '/':
            if self.delete_blocks is None:
                raise Refused(line, 'a slash block without BLKD')
            if self.delete_blocks:
                return
            text = text[1:]
        if QUIET.fullmatch(text) or text.startswith('$uvis,') or re.fullmatch(r'G34(,[0-9.]+)+', text):
            return
        if self.text_block(text, line) or self.body_setup(text, line):
            return
        self.word_block(self.words(text, line), text, line)

    def text_block(self, text, line):
        """Commands with a comma and text; False if it is another block."""
        head, _, rest = text.partition(',')
        if head == 'M45' and rest:
            lines = [rest]
            while lines[-1].endswith('\\'):
                lines.append(self.cursor.next_block(line)[1])
            self.emit('message', (), line, text='\n'.join(text.removesuffix('\\') for text in lines))
        elif head == 'M47' and rest:
            self.emit('message', (), line, text=rest)
        elif head in ('M97', 'M98') and rest:
            self.start_pattern_break()
            self.text(head[1:], rest)
        elif head == 'M99' and rest:
            self.subprogram(rest, line)
        elif head == 'CAN_TEXT_OFF':
            self.text_offset_command(rest.split(',') if rest else [], line)
        elif re.fullmatch(r'M5[01],[0-9]+|M52(,[0-9]+)?', text):
            pass  # vision step and repeat: corrections, which are zero on a nominal panel
        else:
            return False
        return True

    def body_setup(self, text, line):
        """A header command in the body: as in the header, in its place, or where there is no header."""
        if self.header_lines is not None and text not in self.header_lines:
            return bool(re.fullmatch(r'[0-9]+(/[0-9]+)+|/', text))
        if self.header_lines is not None:
            return not text.startswith('T')
        return self.setup_command(text, line)

    def words(self, text, line):
        """Words of a block, Format 1 codes as their Format 2 equivalents."""
        if text == '%':
            return [('M', '25')]
        words = split_words(text, line)
        if not self.format_one:
            return words
        if any(word in NOT_IN_FORMAT_ONE for word in words):
            raise Refused(line, 'a Format 2 command under FMAT,1')
        return [FORMAT_TWO_OF_ONE.get(word, word) for word in words]

    def section_code(self, text):
        """M25, M01, M02, M08, M08M30 or R (a repeat block) if the block is one of these, else None."""
        if text != '%' and not re.fullmatch(r'([A-Z][+-]?[0-9]*\.?[0-9]*)+', text):
            return None
        words = self.words(text, 0)
        if words == [('M', '08'), ('M', '30')]:
            return 'M08M30'
        if len(words) == 1 and words[0] in (('M', '25'), ('M', '01'), ('M', '08')):
            return 'M' + words[0][1]
        if words[0] == ('M', '02'):
            return 'M02'
        if words[0][0] == 'R' and words[1:2] == [('M', '02')]:
            return 'R'
        return None

    def word_block(self, words, text, line):
        letter, value = words[0]
        if letter == 'P':
            self.repeat_pattern(words, line)
            return
        self.start_pattern_break(letter != 'R' and not (letter, value) in (('G', '90'), ('G', '91')))
        cycle = [i for i, (head, code) in enumerate(words) if head == 'G' and code in ('84', '85', '87')]
        if letter in 'XY' and cycle:
            self.last_hole = False
            self.canned(words, cycle[0], line)
        elif letter in 'XY' and not self.routing:
            self.hole(words, line)
        elif letter in 'XYAIJ':
            self.rout_block(None, words, line)
        elif letter == 'F' and len(words) == 1:
            self.feed_block(value, line)
        elif letter == 'T':
            self.tool_command(text, line, in_header=False)
        elif letter == 'R':
            self.repeat_hole(words, line)
        elif letter == 'G':
            self.g_block(value, words[1:], line)
        elif letter == 'M':
            self.m_block(value, words[1:], line)
        else:
            raise Refused(line, f'block "{text}"')

    def feed_block(self, text, line):
        """F# alone: the table's feed in the rout mode, else the infeed of the tool in use."""
        if self.routing:
            self.state_table_feed(text, line)
        else:
            self.set_tool_word(self.current_tool(line), 'F', text, line)

    def g_block(self, code, words, line):
        alone = {'05': self.drill_mode_block, '40': self.compensate, '41': self.compensate, '42': self.compensate,
                 '90': self.coordinates, '91': self.coordinates}
        if code not in ('90', '91'):
            self.last_hole = False
        if code in alone:
            if words:
                raise Refused(line, f'G{code} with other words')
            alone[code](code, line)
        elif code in ('00', '01', '02', '03'):
            self.rout_block(code, words, line)
        elif code in ('32', '33'):
            self.routed_circle(code, words, line)
        elif code in ('81', '82', '83'):
            self.package('82' if code == '81' else code, words, line)
        elif code == '04':
            self.dwell(words, line)
        elif code == '07':
            self.axes(words, '', line)
            self.override = True
        elif code == '93':
            self.set_zero(words, line)
        elif code in ('35', '36', '37', '45', '46', '47', '38', '48'):
            self.vision(code, words, line)
        else:
            raise Refused(line, f'G{code}')

    def m_block(self, code, words, line):
        self.last_hole = False
        if code in ('00', '30', '06', '09'):
            self.stop(code, words, line)
            return
        if words:
            raise Refused(line, f'M{code} with other words')
        if code in ('14', '15'):
            self.plunge(code, line)
        elif code in ('16', '17'):
            self.retract(code, line)
        elif code == '25':
            self.section(line)
        elif code in ('71', '72'):
            self.unit(code == '72', line)
        else:
            raise Refused(line, f'M{code}')

    def stop(self, code, words, line):
        """M00, M30 end the program; M06, M09 stop. Their coordinates are absolute and drill nothing."""
        if self.plunged:
            raise Refused(line, f'M{code} in the rout position')
        if code in ('00', '30'):
            if self.in_section or self.in_subprogram:
                raise Refused(line, f'M{code} inside a pattern')
            self.ended = True
        axes = self.axes(words, 'XY', line)
        if axes and set(axes) != {'X', 'Y'}:
            raise Refused(line, f'M{code} with one coordinate')
        place = tuple(self.format.length_mm(axes[axis], line) for axis in 'XY') if axes else None
        self.emit('stop', (place,) if place else (), line, code=f'M{code}')
        if axes:
            self.forget_position()

    def dwell(self, words, line):
        """G04X#: increments of the coordinate format, 1 ms each."""
        text = self.axes(words, 'X', line).get('X', '')
        if not re.fullmatch(r'[0-9]*', text):
            raise Refused(line, 'G04 without a whole number')
        units = self.format.length_mm(text, line) / self.format.scale(line)
        self.emit('dwell', (), line, increments=int(units * 10 ** self.format.digits()[1]))

    def section(self, line):
        if self.in_section or self.plunged or self.side:
            raise Refused(line, 'M25 inside a pattern, in the rout position or under compensation')
        section = read_section(self.cursor, self, line)
        outer, self.in_section = self.placement, True
        first, feed = True, self.table_feed_mm_s
        for placement, tool_blocks, self.path in section.copies():
            if self.incremental and first and not (self.accumulated and self.position == [0, 0]):
                raise Refused(line, 'an incremental pattern that does not start at work zero')
            self.start_pass()
            for block in tool_blocks:
                self.tool_command(block, line, in_header=False)
            self.placement = outer.after(placement)
            modes = (self.incremental, self.routing, None, False, list(self.text_offset))
            self.feed_unclear = self.table_feed_mm_s != feed
            self.execute(Cursor(section.pattern))
            if (self.incremental, self.routing, self.side, self.plunged, self.text_offset) != modes:
                raise Refused(line, 'a pattern that ends in another mode than it began, plunged or compensated')
            first = False
        self.placement, self.in_section, self.path = outer, False, None
        self.feed_unclear = False
        self.start_pass()
        if section.ends_program:
            self.stop('30', [], section.end_line)

    def start_pass(self):
        """A copy starts: incremental accumulators stand at work zero, absolute axes are to be stated."""
        self.forget_position()
        self.interpolation, self.arc = None, None
        self.start_pattern_break()
        if self.incremental:
            self.position, self.accumulated = [Fraction(0), Fraction(0)], True

    def subprogram(self, name, line):
        """M99,name and a block with its place: the pattern under a temporary work zero."""
        if name not in self.subprograms or self.in_subprogram or self.plunged or self.routing:
            raise Refused(line, f'pattern "{name}"')
        at, block = self.cursor.next_block(line)
        self.move(split_words(block, at), at)
        anchor = self.point(at)
        lines = numbered(self.subprograms[name])

        def again(dx, dy, _):
            outer = self.placement
            self.placement = outer.after(Placement(dx=anchor[0] + dx, dy=anchor[1] + dy))
            self.in_subprogram, self.file = True, name
            self.start_pass()
            self.execute(Cursor(lines))
            self.placement, self.in_subprogram, self.file = outer, False, None
            self.forget_position()

        again(0, 0, line)
        self.pattern, self.pattern_offset = again, (Fraction(0), Fraction(0))

    def set_zero(self, words, line):
        if self.in_section or self.in_subprogram:
            raise Refused(line, 'G93 inside a pattern')
        self.zero = self.spacing(words, line)
        if len(words) != 2:
            raise Refused(line, 'G93 without both coordinates')
        if self.moved:
            self.forget_position()

    def vision(self, code, words, line):
        """Measurements and vision corrected holes, on a panel that lies where the program expects it."""
        if code in ('37', '47'):
            if words:
                raise Refused(line, f'G{code} with other words')
            return
        axes = self.axes(words, 'XY', line)
        if set(axes) != {'X', 'Y'} or self.incremental:
            raise Refused(line, f'G{code} without both coordinates, or incremental')
        place = tuple(self.format.length_mm(axes[axis], line) for axis in 'XY')
        if code in ('38', '48'):
            self.emit('hole', (place,), line)
        self.forget_position()

    def coordinates(self, code, line):
        self.incremental = code == '91'

    def drill_mode_block(self, code, line):
        if self.plunged:
            raise Refused(line, f'G{code} in the rout position')
        self.drill_mode()

    def drill_mode(self):
        self.routing, self.interpolation, self.side = False, None, None

    def select_tool(self, number, index, line):
        if self.plunged:
            raise Refused(line, 'a tool change in the rout position')
        if self.side and index != self.tool_index:
            # "Tool Selection with Compensation Index": entered before G00.
            raise Refused(line, 'another compensation index behind G00')
        self.tool, self.tool_index = number, index
        # "Cutter Compensation Left": the side stays until G00, G40 or G42.
        self.interpolation = None

    def current_tool(self, line):
        if self.tool is None:
            raise Refused(line, 'an operation before a tool')
        return self.tools[self.tool]

    def tool_index_of(self, line):
        self.current_tool(line)
        return self.tool_index

    def axes(self, words, allowed, line):
        """{letter: number text}; refuses other letters and letters stated twice."""
        found = {}
        for letter, text in words:
            if letter not in allowed or letter in found:
                raise Refused(line, f'word {letter}{text}')
            found[letter] = text
        return found

    def move(self, words, line):
        """Sets the position that X and Y state, absolute or incremental."""
        axes = self.axes(words, 'XY', line)
        if not axes or (self.incremental and not self.accumulated):
            raise Refused(line, 'no coordinate, or an incremental one whose start the manual does not say')
        for i, axis in enumerate('XY'):
            value = self.format.length_mm(axes[axis], line) if axis in axes else None
            if self.incremental:
                self.position[i] += value or 0
            elif value is not None:
                self.position[i] = value
            elif not self.known[i]:
                raise Refused(line, f'{axis} left out where the manual does not say its value')
        self.known, self.accumulated, self.moved, self.last_hole = [True, True], True, True, False

    def point(self, line):
        if self.known != [True, True]:
            raise Refused(line, 'a place that the manual does not say')
        return tuple(self.position)

    def forget_position(self):
        self.known, self.accumulated, self.last_hole = [False, False], False, False

    def start_pattern_break(self, breaks=True):
        """P repeats a stored pattern only directly after it."""
        if breaks:
            self.pattern = None

    def emit(self, kind, points, line, **values):
        tool = replace(self.current_tool(line)) if kind not in UNTOOLED else None
        operation = Operation(kind, line, tool, points, values, self.zero, self.file, self.path)
        self.operations.append(operation.placed(self.placement))


def read_program(text, subprograms=None):
    """Executes a part program; raises Refused with the source line."""
    return Interpreter(subprograms).run(text)
