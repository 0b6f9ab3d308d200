# SPDX-License-Identifier: Apache-2.0
"""Header commands: units, tools, switches. Sections "Writing a Part Program" and "Tool Commands"."""
import re
from fractions import Fraction

from .model import Refused, Tool
from .words import METRIC_DIGITS, MM_PER_INCH, integer, rate, spindle_speed_rpm, split_words

# Commands of the table "Commands Used in a Header" and of the sample program's header that change no position.
SWITCHES = {'AFS', 'ATC', 'DETECT', 'DN', 'DTMDIST', 'FSB', 'HPCK', 'NCSL', 'OSTOP', 'OTCLMP', 'PCKPARAM', 'PF',
            'PPR', 'PVS', 'RSB', 'SBK', 'SG', 'TCST', 'UP'}
RESETS = {'R,C', 'R,CP', 'R,CR', 'R,D', 'R,H', 'R,T'}


class Setup:
    """The part of the interpreter that reads set-up commands; state is made by Interpreter."""

    def setup_command(self, text, line):
        """Executes a header command; False if it is another block."""
        name, *options = text.split(',')
        if text in RESETS:
            if text == 'R,T':
                self.tools.clear()
            return True
        handler = {'INCH': self.inch, 'METRIC': self.metric, 'VER': self.version, 'FMAT': self.format_number,
                   'ICI': self.incremental_input, 'BLKD': self.block_delete, 'CP': self.compensation_value}.get(name)
        if handler:
            handler(options, line)
            return True
        if name in SWITCHES:
            if not all(re.fullmatch(r'[A-Z]+|[+-]?[0-9]*\.?[0-9]+', option) for option in options):
                raise Refused(line, f'switch "{text}"')
            return True
        if re.fullmatch(r'[0-9]+(/[0-9]+)+|/', text):
            return True  # tool links: positions stay
        return False

    def inch(self, options, line):
        self.unit(True, line)
        self.zeros_option(options, line)

    def metric(self, options, line):
        self.unit(False, line)
        if options and options[-1] in METRIC_DIGITS:
            self.format.metric_digits = METRIC_DIGITS[options[-1]]
            options = options[:-1]
        self.zeros_option(options, line)

    def unit(self, inch, line):
        if self.format.inch is not None and self.format.inch != inch:
            raise Refused(line, 'the program states both inch and metric')
        if self.worked():
            raise Refused(line, 'a unit after the first operation')
        self.format.inch = inch

    def worked(self):
        """True from the first hole or plunge on."""
        return any(operation.tool for operation in self.operations)

    def zeros_option(self, options, line):
        if not options:
            return
        if len(options) != 1 or options[0] not in ('LZ', 'TZ'):
            raise Refused(line, f'unit option "{",".join(options)}"')
        if self.format.zeros not in (None, options[0]):
            raise Refused(line, 'the program states both LZ and TZ')
        self.format.zeros = options[0]

    def version(self, options, line):
        # The chapter does not say what the other versions do with the axes.
        if options != ['1']:
            raise Refused(line, 'VER other than 1')

    def format_number(self, options, line):
        if options not in (['1'], ['2']):
            raise Refused(line, 'FMAT is not 1 or 2')
        if self.worked():
            raise Refused(line, 'FMAT after the first operation')
        self.format_one = options == ['1']

    def incremental_input(self, options, line):
        self.incremental = self.on_off('ICI', options, line)

    def block_delete(self, options, line):
        self.delete_blocks = self.on_off('BLKD', options, line)

    @staticmethod
    def on_off(name, options, line):
        if options not in (['ON'], ['OFF']):
            raise Refused(line, f'{name} is not ON or OFF')
        return options == ['ON']

    def compensation_value(self, options, line):
        """CP,index,diameter: the value of a compensation index."""
        if len(options) != 2 or '.' not in options[1]:
            raise Refused(line, 'CP is not CP,index,value')
        self.compensation_mm[integer(options[0], line, 'CP index', 2)] = self.format.length_mm(options[1], line)

    def tool_command(self, text, line, in_header):
        """T block: tool data, and in the body the selection. Words act from left to right."""
        words = split_words(text, line)
        number, index = self.tool_number(words[0][1], line)
        tool = self.tools.setdefault(number, Tool(number))
        for letter, value in words[1:]:
            if in_header:
                tool.header_words.discard(letter)
            self.set_tool_word(tool, letter, value, line)
            if in_header:
                tool.header_words.add(letter)
        if not in_header:
            self.select_tool(number, index, line)

    def set_tool_word(self, tool, letter, text, line):
        """One word of tool data. "Keyboard and Header Commands vs. Body Commands": the header's option stays."""
        name, parsed = self.tool_word(letter, text, line)
        if letter not in tool.header_words or (self.override and letter in 'FS'):
            setattr(tool, name, parsed)

    def feed_mm_s(self, text, line):
        """F: inch/min or mm/s."""
        return rate(text, line, 'F', 3) * (MM_PER_INCH / 60 if self.format.inch else 1)

    @staticmethod
    def tool_number(text, line):
        """(tool, compensation index) of T#(#): one or two digits, or four with the index last."""
        if not re.fullmatch(r'[0-9]{1,2}|[0-9]{4}', text):
            raise Refused(line, f'tool number "{text}"')
        number = int(text[:2])
        index = int(text[2:]) if len(text) == 4 else 0
        if number == 0:
            raise Refused(line, 'tool number 0')
        return number, index or number

    def tool_word(self, letter, text, line):
        """(field of Tool, value) of one word of a T block."""
        if letter == 'C':
            return 'diameter_mm', self.diameter(text, line)
        if letter == 'F':
            return 'feed_mm_s', self.feed_mm_s(text, line)
        if letter == 'B':
            return 'retract_mm_s', rate(text, line, 'B', 4) * (MM_PER_INCH / 60 if self.format.inch else 1)
        if letter == 'S':
            return 'speed_rpm', spindle_speed_rpm(text, line)
        if letter == 'H':
            return 'max_hits', integer(text, line, 'H', 6) if text else None
        if letter == 'Z':
            return 'depth_offset_mm', self.format.length_mm(text, line)
        raise Refused(line, f'{letter} in a tool block')

    def diameter(self, text, line):
        value = self.format.length_mm(text, line, leading_only=True)
        if not text or value < 0:
            raise Refused(line, f'C: "{text}" is no diameter')
        return value or None  # zero: not specified ("Canned Circle")

    def compensation_of(self, index, line):
        """Diameter by which the path is compensated, mm."""
        if index not in self.compensation_mm:
            raise Refused(line, f'compensation index {index} has no value in the program')
        return self.compensation_mm[index]


def fraction_sqrt(value):
    """Square root of a non-negative Fraction: exact for squares, else good to about 1e-15 relative."""
    root = Fraction(float(value) ** 0.5)
    if not root:
        return Fraction(0)
    root = (root + value / root) / 2
    candidate = root.limit_denominator(10 ** 7)
    return candidate if candidate * candidate == value else root
