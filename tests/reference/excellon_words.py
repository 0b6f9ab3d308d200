# SPDX-License-Identifier: Apache-2.0
"""Words, header and tools of random Excellon programs."""
from fractions import Fraction
import re

FORMAT_ONE_OF_TWO = {'G05': 'G81', 'M00': 'M02', 'M01': 'M24', 'M02': 'M26', 'M06': 'M01', 'M08': 'M27', 'M09': 'M00',
                     'M70': 'M23', 'M72': 'M70', 'M80': 'M21', 'M90': 'M22'}


class Numbers:
    """Writes lengths, in units of the program, in its format: with a decimal point, or digits with LZ or TZ."""

    def __init__(self, random, inch, zeros, digits):
        self.random, self.inch, self.zeros, self.digits = random, inch, zeros, digits
        self.per_inch = Fraction(1) if inch else Fraction(127, 5)

    def grid(self):
        return Fraction(1, 10 ** self.digits[1])

    def decimal(self, value):
        sign, value = '-' if value < 0 else '', abs(value)
        places = 0
        while (value * 10 ** places).denominator != 1:
            places += 1
        text = str(int(value * 10 ** places)).rjust(places + 1, '0')
        whole, part = text[:len(text) - places], text[len(text) - places:]
        if self.random.random() < 0.5 and whole == '0' and part:
            whole = ''
        return f'{sign}{whole}.{part}'

    def text(self, value):
        before, after = self.digits
        steps = value * 10 ** after
        if (self.zeros is None or steps.denominator != 1 or abs(steps) >= 10 ** (before + after) or
                self.random.random() < 0.4):
            return self.decimal(value)
        if steps == 0:
            return self.random.choice(('', '0'))
        sign, steps = '-' if steps < 0 else self.random.choice(('', '', '+')), abs(int(steps))
        if self.zeros == 'LZ':
            return sign + str(steps).rjust(before + after, '0').rstrip('0')
        return sign + self.random.choice((str(steps), str(steps).rjust(before + after, '0')))


class WordWriter:
    """Lines of one program, and what the control knows where they end."""

    def __init__(self, random):
        self.random = random
        self.lines, self.subprograms = [], {}
        self.has_header = random.random() < 0.85
        inch = random.random() < 0.5
        zeros = random.choice(('LZ', 'TZ')) if self.has_header else None
        self.metric_name = random.choice(('', '000.000', '0000.00', '000.00'))
        digits = (2, 4) if inch else {'': (3, 3), '000.000': (3, 3), '0000.00': (4, 2), '000.00': (3, 2)}[self.metric_name]
        self.numbers = Numbers(random, inch, zeros, digits)
        self.format = random.choice((None, None, 2, 2, 1)) if self.has_header else None
        self.deletes = random.choice((None, True, False)) if self.has_header else None
        self.incremental = False
        self.position = [Fraction(0), Fraction(0)]
        self.known, self.from_here, self.at_zero = False, True, True
        self.tools, self.tool, self.index = {}, None, None  # number: diameter in units, or None
        self.indices = {}  # compensation index: diameter in units
        self.hole = False
        self.arc = None  # radius in force, 'centre', or None
        self.in_section = self.in_pattern = False
        self.ended = False
        self.may_select = True  # not where a copy would begin with another tool than the pattern did
        self.states_feed = None  # every contour of a pattern states its feed, or none does

    # Words

    def add(self, text):
        if self.format == 1 and not re.match(r'M9[789],|M4[57],', text):
            text = re.sub(r'[GM][0-9][0-9](?![0-9])', lambda match: FORMAT_ONE_OF_TWO.get(match[0], match[0]), text)
        self.lines.append(text)

    def length(self, low, high):
        """A length between two numbers of inches, in units on the format's grid, rarely off it."""
        grid = self.numbers.grid()
        if self.random.random() < 0.1:
            grid /= 10
        low, high = (int(Fraction(limit) * self.numbers.per_inch / grid) for limit in (low, high))
        return self.random.randint(low, high) * grid

    def point(self):
        return [self.length(-2, 6), self.length(-2, 6)]

    def axes(self, target):
        """X and Y words that take the control to the target; changes the state."""
        written = ''
        for i, axis in enumerate('XY'):
            value = target[i] - self.position[i] if self.incremental else target[i]
            stays = value == 0 if self.incremental else self.known and target[i] == self.position[i]
            if not stays or (i == 1 and not written) or self.random.random() < 0.3:
                written += axis + self.numbers.text(value)
        self.position, self.known, self.from_here, self.at_zero = list(target), True, True, False
        self.hole = False
        return written

    def ready(self):
        """Makes sure that the next coordinate has a start."""
        if self.incremental and not self.from_here:
            self.add('G90')
            self.incremental = False

    def next_point(self):
        """Somewhere else, often along one axis."""
        target = self.point()
        if self.known and self.random.random() < 0.4:
            i = self.random.randrange(2)
            target[i] = self.position[i]
        return target

    def forget(self):
        self.known = self.from_here = self.at_zero = self.hole = False

    def spacing(self, low=-1, high=1):
        """X#Y# of a distance, and its two lengths."""
        dx, dy = (self.length(low, high) if self.random.random() < 0.9 else Fraction(0) for _ in range(2))
        which = self.random.randrange(4)
        if which == 0:
            return 'X' + self.numbers.text(dx), dx, 0
        if which == 1:
            return 'Y' + self.numbers.text(dy), 0, dy
        return f'X{self.numbers.text(dx)}Y{self.numbers.text(dy)}', dx, dy

    # Header and tools

    def header(self):
        random = self.random
        self.add('M48')
        if random.random() < 0.3:
            self.add('; a comment')
        for word in random.sample(('R,C', 'R,H', 'VER,1', 'ATC,ON', 'SBK,OFF', 'DETECT,ON', 'FSB,ON', 'OSTOP,OFF'), 3):
            self.add(word)
        if self.format:
            self.add(f'FMAT,{self.format}')
        unit = 'INCH' if self.numbers.inch else 'METRIC'
        unit += f',{self.numbers.zeros}'
        if not self.numbers.inch and self.metric_name:
            unit += f',{self.metric_name}'
        self.add(unit)
        if random.random() < 0.3:
            self.incremental = random.random() < 0.5
            self.add('ICI,' + ('ON' if self.incremental else 'OFF'))
        if self.deletes is not None:
            self.add('BLKD,' + ('ON' if self.deletes else 'OFF'))
        for number in random.sample(range(1, 30), random.randint(1, 4)):
            self.tool_row(number)
        for index in random.sample(sorted(self.tools), min(2, len(self.tools))):
            self.indices[index] = self.length(Fraction(2, 100), Fraction(1, 10))
            self.add(f'CP,{index},{self.numbers.decimal(self.indices[index])}')
        self.add(random.choice(('%', 'M95')))

    def tool_words(self, diameter):
        """C and other tool words, in any order."""
        random = self.random
        # Under TZ the manual leaves open how the digits of C are read.
        write = self.numbers.text if self.numbers.zeros == 'LZ' else self.numbers.decimal
        words = [] if diameter is None else ['C' + write(diameter).lstrip('+')]
        if random.random() < 0.6:
            words.append('F' + random.choice(('1', '08', '100', '05', '073')))
        if random.random() < 0.5:
            words.append('S' + random.choice(('65', '6', '612', '110.5', '20')))
        if random.random() < 0.3:
            words.append('B' + random.choice(('03', '0300', '0025')))
        if random.random() < 0.3:
            words.append('H' + random.choice(('20000', '')))
        if random.random() < 0.3:
            words.append('Z' + random.choice(('-', '')) + self.numbers.text(self.length(0, Fraction(1, 20))).lstrip('+'))
        random.shuffle(words)
        return ''.join(words)

    def tool_row(self, number):
        diameter = self.length(Fraction(1, 50), Fraction(1, 8)) if self.random.random() < 0.8 else None
        self.tools[number] = diameter
        self.add(f'T{self.tool_text(number)}{self.tool_words(diameter)}')

    def tool_text(self, number):
        return self.random.choice((str(number), str(number).rjust(2, '0')))

    def use_tool(self, number):
        """Takes a tool, at times with the compensation index in the last two of four digits."""
        self.tool, self.index = number, number
        text = self.tool_text(number)
        if self.random.random() < 0.2:
            self.index = self.random.choice([0, *self.indices, number])
            text = f'{number:02}{self.index:02}'
            self.index = self.index or number
        self.add(f'T{text}')

    def select_tool(self):
        """A tool, at times with data that the header overrides, or of which the header knows nothing."""
        if not self.may_select:
            return
        random = self.random
        number = random.choice(sorted(self.tools)) if self.tools and random.random() < 0.9 else random.randint(1, 40)
        self.tool = self.index = number
        if number not in self.tools:
            self.tool_row(number)
        elif random.random() < 0.1:
            self.add(f'T{self.tool_text(number)}' + random.choice(('F09', 'S40', 'F02S33')))
        else:
            self.use_tool(number)
