# SPDX-License-Identifier: Apache-2.0
"""Random Excellon programs of every construct that the reading from the manual and panelcal both execute."""
from fractions import Fraction

from excellon_words import WordWriter

VECTORS = ((3, 4), (4, 3), (5, 0), (0, 5), (-3, 4), (-4, 3), (-5, 0), (0, -5), (3, -4), (4, -3), (-3, -4), (-4, -3))
CHARACTERS = 'ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-/,'


class Writer(WordWriter):
    """Writes a whole program out of random constructs."""

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
            compensated = self.index in self.indices and random.random() < 0.5
            if compensated:
                self.add(random.choice(('G41', 'G42')))
            mode = '00'
            for _ in range(random.choice((1, 1, 2))):
                self.add(random.choice(('M15', 'M15', 'M14')))
                for _ in range(random.randint(1, 4)):
                    mode = self.contour_move(mode)
                self.add(random.choice(('M16', 'M17')))
            if compensated and random.random() < 0.3:
                self.add('G40')
        self.add('G05')

    def contour_move(self, mode):
        """One line or arc; codes and arc words at times in a block of their own, or left out where they are in force."""
        random = self.random
        kind = random.choice(('01', '01', '02', '03'))
        code = f'G{kind}' if mode != kind or random.random() < 0.3 else ''
        if kind == '01':
            words, arc = self.axes(self.next_point()), ''
        elif random.random() < 0.5:
            words, arc = self.arc_by_centre(kind)
        else:
            words, arc = self.arc_by_radius()
        if code and random.random() < 0.2:
            self.add(code)
            code = ''
        if arc and random.random() < 0.1:
            self.add(arc)
            arc = ''
        feed = random.choice(('F04', 'F12')) if code and not self.in_section and random.random() < 0.1 else ''
        self.add(code + words + arc + feed)
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
        self.arc = 'centre'
        return self.axes(end), f'I{self.numbers.text(a[0] * scale)}J{self.numbers.text(a[1] * scale)}'

    def arc_by_radius(self):
        end = self.next_point()
        if end == self.position:
            end[0] += self.numbers.grid()
        half2 = ((end[0] - self.position[0]) ** 2 + (end[1] - self.position[1]) ** 2) / 4
        if self.arc not in (None, 'centre') and self.arc ** 2 >= half2 and self.random.random() < 0.5:
            return self.axes(end), ''
        self.arc = (int(float(half2) ** 0.5 / self.numbers.grid()) + 1) * self.numbers.grid() + self.length(0, 2)
        return self.axes(end), f'A{self.numbers.text(self.arc)}'

    def routed_circle(self):
        if self.index not in self.indices:
            return
        self.ready()
        self.arc = self.indices[self.index] / 2 + self.length(Fraction(2, 100), Fraction(1, 2))
        self.add(f'{self.random.choice(("G32", "G33"))}{self.axes(self.next_point())}A{self.numbers.text(self.arc)}')
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
        if self.in_section:
            return
        if self.incremental and not self.at_zero:
            self.add('G90')
            self.incremental = False
        self.in_section, began = True, self.incremental
        self.add(self.random.choice(('M25', '%')))
        self.start_pass()
        self.states_feed = self.random.random() < 0.5
        selected = self.may_select
        if self.random.random() < 0.5:
            self.select_tool()
        else:
            self.may_select = False
        for _ in range(self.random.randint(1, 4)):
            self.construct()
        if self.incremental != began:
            self.add('G91' if began else 'G90')
            self.incremental = began
        for level in range(self.random.choice((1, 1, 1, 2, 3))):
            self.add('M01')
            self.level()
        if self.random.random() < 0.2:
            self.add('M01')
        self.in_section, self.may_select = False, selected
        self.start_pass()
        if not self.in_pattern and self.random.random() < 0.05:
            self.add('M08M30')
            self.ended = True
            return
        self.add('M08')
        self.select_tool()

    def start_pass(self):
        self.forget()
        self.arc = None
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
            if not (repeats or self.in_pattern) and random.random() < 0.1:
                tool = random.choice([f'T{number}' for number in self.tools if self.same_kind(number)] or [''])
            self.add(f'{repeats}M02{self.spacing(-3, 3)[0]}{mirrors}{tool}')
            bare = not repeats
        if bare or random.random() < 0.3:
            self.add('M02')

    def same_kind(self, number):
        """True if the tool can do all that a pattern of the one in use can: its size is as stated, its index too."""
        known = (self.tools[number] is None) == (self.tools[self.tool] is None)
        return known and not {number, self.index} & set(self.indices)

    def stored_pattern(self):
        """M99 with a file of its own."""
        if self.in_pattern:
            return
        self.ready()
        name = f'PAT{len(self.subprograms) + 1}'
        outer, began = self.lines, self.incremental
        anchor = self.axes(self.point())
        self.lines, self.in_pattern = [], True
        selected, self.may_select = self.may_select, self.may_select and self.random.random() < 0.5
        repeats = not self.may_select  # each repeat begins with the tool of the first
        self.start_pass()
        for _ in range(self.random.randint(1, 3)):
            self.construct()
        if self.incremental != began:
            self.add('G91' if began else 'G90')
            self.incremental = began
        self.subprograms[name] = '\n'.join(self.lines) + '\n'
        self.lines, self.in_pattern, self.may_select = outer, False, selected
        self.add(f'M99,{name}')
        self.add(anchor)
        if repeats:
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
                   (self.step_slot, 1), (self.section, 3), (self.stored_pattern, 1), (self.event, 3),
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
            if self.ended:
                return '\n'.join(self.lines) + '\n', self.subprograms
        end = self.random.choice(('M30', 'M30', 'M00'))
        if self.random.random() < 0.2:
            end += f'X{self.numbers.text(self.length(0, 5))}Y{self.numbers.text(self.length(0, 5))}'
        self.add(end)
        return '\n'.join(self.lines) + '\n', self.subprograms
