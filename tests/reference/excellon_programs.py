# SPDX-License-Identifier: Apache-2.0
"""Random Excellon programs of every construct that the reading from the manual and panelcal both execute."""
from fractions import Fraction
import re

VECTORS = ((3, 4), (4, 3), (5, 0), (0, 5), (-3, 4), (-4, 3), (-5, 0), (0, -5), (3, -4), (4, -3), (-3, -4), (-4, -3))
FORMAT_ONE_OF_TWO = {'G05': 'G81', 'M00': 'M02', 'M01': 'M24', 'M02': 'M26', 'M06': 'M01', 'M08': 'M27', 'M09': 'M00',
                     'M70': 'M23', 'M72': 'M70', 'M80': 'M21', 'M90': 'M22'}
CHARACTERS = 'ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-/,'


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


class Writer:
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
        self.tools, self.tool = {}, None  # number: diameter in units, or None
        self.indices = {}  # compensation index: diameter in units
        self.hole = False
        self.radius = None
        self.in_section = self.in_pattern = False
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
        dx, dy = self.length(low, high), self.length(low, high)
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
        words = [] if diameter is None else [('C' + self.numbers.decimal(diameter))]
        if random.random() < 0.6:
            words.append('F' + random.choice(('1', '08', '100', '05', '073')))
        if random.random() < 0.5:
            words.append('S' + random.choice(('65', '6', '612', '110.5', '20')))
        if random.random() < 0.3:
            words.append('B' + random.choice(('03', '0300', '0025')))
        if random.random() < 0.3:
            words.append('H' + random.choice(('20000', '')))
        if random.random() < 0.3:
            words.append('Z' + random.choice(('-', '')) + self.numbers.decimal(self.length(0, Fraction(1, 20))))
        random.shuffle(words)
        return ''.join(words)

    def tool_row(self, number):
        diameter = self.length(Fraction(1, 50), Fraction(1, 8)) if self.random.random() < 0.8 else None
        self.tools[number] = diameter
        self.add(f'T{self.tool_text(number)}{self.tool_words(diameter)}')

    def tool_text(self, number):
        return self.random.choice((str(number), str(number).rjust(2, '0')))

    def select_tool(self):
        """A tool, at times with data that the header overrides, or of which the header knows nothing."""
        if not self.may_select:
            return
        random = self.random
        number = random.choice(sorted(self.tools)) if self.tools and random.random() < 0.9 else random.randint(1, 40)
        if number not in self.tools:
            self.tool_row(number)
        elif random.random() < 0.1:
            self.add(f'T{self.tool_text(number)}' + self.random.choice(('F09', 'S40', 'F02S33')))
        else:
            self.add(f'T{self.tool_text(number)}')
        self.tool = number

    # Drilling

    def drill(self):
        self.ready()
        self.add(self.axes(self.next_point()))
        self.hole = True

    def repeat(self):
        if not self.hole:
            self.drill()
        count = self.random.choice((1, 2, 3, 9, 12))
        text, dx, dy = self.spacing(Fraction(-1, 4), Fraction(1, 4))
        self.add(f'R{self.random.choice((str(count), str(count).rjust(2, "0")))}{text}')
        self.position = [self.position[0] + count * dx, self.position[1] + count * dy]

    def package(self):
        """G82 or G81 between two corners whose rows lie along x or y; the spacings stated or not."""
        random, grid = self.random, self.numbers.grid()
        pitch, row = self.numbers.per_inch / 10, self.numbers.per_inch * 3 / 10
        words = ''
        if random.random() < 0.6:
            pitch, row = self.length(Fraction(1, 20), Fraction(1, 5)), self.length(Fraction(1, 4), Fraction(1, 2))
            words = f'X{self.numbers.text(pitch)}Y{self.numbers.text(row)}'
        along, across = random.randint(1, 9) * pitch, row
        if abs(along - across) <= 10 * grid:
            along += pitch
        span = [along * random.choice((1, -1)), across * random.choice((1, -1))]
        if random.random() < 0.5:
            span.reverse()
        self.corners(('G82' if self.format == 1 else random.choice(('G82', 'G81'))) + words, span)

    def l_pack(self):
        span = [self.numbers.per_inch * 4 / 10 * self.random.choice((1, -1)), Fraction(0)]
        if self.random.random() < 0.5:
            span.reverse()
        self.corners('G83', span)

    def corners(self, command, span):
        self.ready()
        self.add(command)
        first = self.point()
        self.add(self.axes(first))
        self.add(self.axes([first[0] + span[0], first[1] + span[1]]))
        self.repeat_pattern()

    def repeat_pattern(self):
        if self.random.random() < 0.4:
            self.add(f'P{self.random.choice(("1", "02", "3"))}{self.spacing()[0]}')
            self.forget()

    def circle(self):
        self.ready()
        diameter = self.tools[self.tool] or self.numbers.per_inch / 8
        hole = 2 * diameter + self.length(0, Fraction(2, 10))
        self.add(f'{self.axes(self.next_point())}G84X{self.numbers.text(hole)}')
        self.repeat_pattern()

    def slot(self):
        if not self.tools[self.tool]:
            return
        self.ready()
        start = self.axes(self.next_point())
        end = [self.position[0] + self.length(-1, 1), self.position[1] + self.length(Fraction(1, 10), 1)]
        self.add(f'{start}G85{self.axes(end)}')
        self.repeat_pattern()

    def text(self):
        self.ready()
        letters = ''.join(self.random.choice(CHARACTERS) for _ in range(self.random.randint(1, 6)))
        if self.random.random() < 0.2:
            letters = letters[:2] + '*' + letters[2:]
        self.add(f'{self.random.choice(("M97", "M98"))},{letters}')
        self.add(self.axes(self.point()))

    # Routing

    def contour(self):
        """G00, compensation, plunge, moves, retract; then the drill mode again."""
        random = self.random
        for _ in range(random.randint(1, 2)):
            self.ready()
            states = self.states_feed if self.in_section else random.random() < 0.3
            self.add('G00' + self.axes(self.next_point()) + (random.choice(('F03', 'F1')) if states else ''))
            if random.random() < 0.2 and not self.in_section:
                self.add('F' + random.choice(('02', '1')))
            compensated = self.tool in self.indices and random.random() < 0.5
            if compensated:
                self.add(random.choice(('G41', 'G42')))
            self.add(random.choice(('M15', 'M15', 'M14')))
            mode = '00'
            for _ in range(random.randint(1, 5)):
                mode = self.contour_move(mode)
            self.add(random.choice(('M16', 'M17')))
            if compensated and random.random() < 0.3:
                self.add('G40')
        self.add('G05')

    def contour_move(self, mode):
        kind = self.random.choice(('01', '01', '02', '03'))
        if kind == '01':
            code = 'G01' if mode != '01' or self.random.random() < 0.3 else ''
            if code and self.random.random() < 0.2:
                self.add(code)
                code = ''
            self.add(code + self.axes(self.next_point()))
            return kind
        code = f'G{kind}' if mode != kind or self.random.random() < 0.3 else ''
        self.add(code + (self.arc_by_centre(kind) if self.random.random() < 0.5 else self.arc_by_radius()))
        return kind

    def arc_by_centre(self, kind):
        """An arc of at most half a circle whose centre and ends are on the grid exactly."""
        random = self.random
        while True:
            a, b = random.choice(VECTORS), random.choice(VECTORS)
            turn = (a[0] * b[1] - a[1] * b[0]) * (-1 if kind == '02' else 1)
            if a != b and turn >= 0:
                break
        scale = self.length(Fraction(1, 50), Fraction(1, 5))
        end = [self.position[i] + (b[i] - a[i]) * scale for i in range(2)]
        self.radius = None
        return f'{self.axes(end)}I{self.numbers.text(a[0] * scale)}J{self.numbers.text(a[1] * scale)}'

    def arc_by_radius(self):
        end = self.next_point()
        if end == self.position:
            end[0] += self.numbers.grid()
        half2 = ((end[0] - self.position[0]) ** 2 + (end[1] - self.position[1]) ** 2) / 4
        if self.radius is not None and self.radius ** 2 >= half2 and self.random.random() < 0.5:
            return self.axes(end)
        self.radius = (int(float(half2) ** 0.5 / self.numbers.grid()) + 1) * self.numbers.grid()
        self.radius += self.length(0, 2)
        return f'{self.axes(end)}A{self.numbers.text(self.radius)}'

    def routed_circle(self):
        if self.tool not in self.indices:
            return
        self.ready()
        self.radius = self.indices[self.tool] / 2 + self.length(Fraction(15, 100), Fraction(1, 2))
        self.add(f'{self.random.choice(("G32", "G33"))}{self.axes(self.next_point())}A{self.numbers.text(self.radius)}')
        self.add('G05')
        self.forget()

    def step_slot(self):
        self.ready()
        start = self.axes(self.next_point())
        end = [self.position[0] + self.length(Fraction(1, 10), 1), self.position[1] + self.length(-1, 1)]
        depth, above = self.length(Fraction(1, 50), Fraction(1, 10)), self.length(0, Fraction(1, 5))
        self.add(f'{start}G87{self.axes(end)}Z-{self.numbers.decimal(depth)}U{self.numbers.decimal(above)}')
        self.add('G05')
        self.forget()

    # Sections, patterns, events

    def section(self):
        if self.in_section or self.in_pattern:
            return
        if self.incremental and not self.at_zero:
            self.add('G90')
            self.incremental = False
        self.in_section, began = True, self.incremental
        self.add(self.random.choice(('M25', '%')))
        self.start_pass()
        self.states_feed = self.random.random() < 0.5
        if self.random.random() < 0.5:
            self.select_tool()
        else:
            self.may_select = False
        for _ in range(self.random.randint(1, 4)):
            self.construct()
        if self.incremental != began:
            self.add('G91' if began else 'G90')
            self.incremental = began
        for level in range(self.random.choice((1, 1, 2, 3))):
            self.add('M01')
            self.level()
        if self.random.random() < 0.2:
            self.add('M01')
        self.add('M08')
        self.in_section, self.may_select = False, True
        self.start_pass()
        self.select_tool()

    def start_pass(self):
        self.forget()
        self.radius = None
        if self.incremental:
            self.position, self.from_here, self.at_zero = [Fraction(0), Fraction(0)], True, True

    def level(self):
        random = self.random
        bare = False
        for _ in range(random.randint(1, 3)):
            mirrors = ''.join(code for code in random.choice((('M80', 'M90'), ('M90', 'M80'))) if random.random() < 0.3)
            mirrors += 'M70' if random.random() < 0.3 else ''
            repeats = random.choice(('', '', 'R2', 'R1', 'R03'))
            tool = ''
            if not repeats and random.random() < 0.1:
                tool = random.choice([f'T{number}' for number in self.tools if self.same_kind(number)] or [''])
            self.add(f'{repeats}M02{self.spacing(-3, 3)[0]}{mirrors}{tool}')
            bare = not repeats
        if bare or random.random() < 0.3:
            self.add('M02')

    def same_kind(self, number):
        """True if the tool can do all that a pattern of the one in use can: its size is as stated, its index too."""
        known = (self.tools[number] is None) == (self.tools[self.tool] is None)
        return known and not {number, self.tool} & set(self.indices)

    def stored_pattern(self):
        """M99 with a file of its own."""
        if self.in_pattern:
            return
        self.ready()
        name = f'PAT{len(self.subprograms) + 1}'
        outer, began = self.lines, self.incremental
        anchor = self.axes(self.point())
        self.lines, self.in_pattern = [], True
        self.start_pass()
        for _ in range(self.random.randint(1, 3)):
            self.construct()
        if self.incremental != began:
            self.add('G91' if began else 'G90')
            self.incremental = began
        self.subprograms[name] = '\n'.join(self.lines) + '\n'
        self.lines, self.in_pattern = outer, False
        self.add(f'M99,{name}')
        self.add(anchor)
        self.repeat_pattern()
        self.forget()

    def event(self):
        """A block that drills nothing."""
        random = self.random
        kind = random.randrange(9)
        if kind == 0:
            self.add(f'{random.choice(("M06", "M09"))}X{self.numbers.text(self.length(0, 5))}'
                     f'Y{self.numbers.text(self.length(0, 5))}')
            self.forget()
        elif kind == 1:
            self.add(random.choice(('M06', 'M09', 'M18', 'M62', 'M63', 'G07')))
        elif kind == 2 and self.numbers.zeros and self.numbers.digits[1] >= 3:
            time = {('LZ', 4): '002', ('LZ', 3): '002', ('TZ', 4): '2500', ('TZ', 3): '2500'}
            self.add('G04X' + time[self.numbers.zeros, self.numbers.digits[1]])
        elif kind == 3:
            self.add('M47,LOAD PANEL')
        elif kind == 4:
            self.add('M45,FIRST\\')
            self.add('SECOND')
        elif kind == 5 and not (self.in_section or self.in_pattern):
            self.add(f'G93X{self.numbers.text(self.length(-1, 3))}Y{self.numbers.text(self.length(-1, 3))}')
            self.forget()
        elif kind == 6 and not self.in_section:
            self.add(f'CAN_TEXT_OFF,{self.numbers.decimal(self.length(-1, 1))},{self.numbers.decimal(self.length(-1, 1))}')
        elif kind == 7 and self.deletes is not None:
            self.ready()
            target = self.next_point()
            if self.deletes:
                self.add('/X1.Y1.')
            else:
                self.add('/' + self.axes(target))
                self.hole = True
            return
        elif kind == 8:
            self.add('F' + random.choice(('02', '1')))
        self.hole = False

    def coordinates(self):
        """G90 or G91."""
        if self.incremental or self.from_here:
            self.incremental = not self.incremental
            self.add('G91' if self.incremental else 'G90')
            self.at_zero = False

    def construct(self):
        choices = ((self.drill, 8), (self.repeat, 4), (self.select_tool, 2), (self.package, 2), (self.l_pack, 1),
                   (self.circle, 1), (self.slot, 2), (self.text, 1), (self.contour, 3), (self.routed_circle, 1),
                   (self.step_slot, 1), (self.section, 3), (self.stored_pattern, 1), (self.event, 2),
                   (self.coordinates, 2))
        self.random.choices([construct for construct, _ in choices], [weight for _, weight in choices])[0]()

    def program(self):
        """(text, texts of stored patterns by name)"""
        if self.has_header:
            self.header()
        else:
            self.add('M72' if self.numbers.inch else 'M71')
        self.select_tool()
        for _ in range(self.random.randint(3, 15)):
            self.construct()
        end = self.random.choice(('M30', 'M30', 'M00'))
        if self.random.random() < 0.2:
            end += f'X{self.numbers.text(self.length(0, 5))}Y{self.numbers.text(self.length(0, 5))}'
        self.add(end)
        return '\n'.join(self.lines) + '\n', self.subprograms
