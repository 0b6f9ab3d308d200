# SPDX-License-Identifier: Apache-2.0
"""Random part programs: every construct that the manual settles and panelcal executes.

Places are whole units of the format, so that I and J, centers and corners are exact.
"""

import random

from .numbers import Setting

DECIMALS = {1000: 2, 3000: 3, 5000: 3}
# (x, y) on circles whose radius is a whole number: arcs by I and J end exactly.
TRIPLES = [(3, 4, 5), (4, 3, 5), (5, 12, 13), (8, 15, 17), (20, 21, 29), (7, 24, 25)]
OFFSETS = ["M50", "M60", "M70", "M80", "M90", "M60M70", "M60M80", "M60M90"]


class Writer:
    """Writes one program. `programs.Writer(seed).program()` -> (text, subprogram text or "").

    others  In other numbers than the manual's tables: `setting` states them.
    """

    def __init__(self, seed, format_=None, others=False):
        self.rng = random.Random(seed)
        self.format = format_ or self.rng.choices([1000, 3000, 5000], [2, 2, 6])[0]
        self.mark = "%%" if self.format == 1000 else f"%%{self.format}"
        self.decimals, self.whole, self.leading, self.unit_mm, self.setting = DECIMALS[self.format], 3, False, 1, None
        if others:
            self.choose_setting(random.Random(-1 - seed))
        self.has_diameters = self.setting is None or self.format != 3000
        self.unit = self.unit_mm / 10 ** self.decimals
        self.diameters = {tool: self.rng.randint(4, 24) * 10 for tool in self.rng.sample(range(1, 16), 4)}  # 0.01 mm
        self.tool = None
        self.nesting = 0
        self.moved = False  # a section around this line rotates or mirrors
        self.subprograms = {}
        self.slm_memory = 0
        self.in_subprogram = False
        self.cycles = ""  # words of drilling lines so far
        self.planes_stated = self.rng.random() < 0.8  # else the operator's Z, K and H hold

    # ---- numbers and lines

    def choose_setting(self, rng):
        """The control's or the operator's numbers."""
        inch, self.leading = rng.random() < 0.85, rng.random() < 0.3
        self.whole, self.decimals = rng.choice([(2, 4), (2, 4), (2, 3), (2, 5)] if inch else [(3, 4), (4, 2), (3, 3), (3, 5)])
        self.unit_mm = 25.4 if inch else 1
        rules = rng.random() < 0.5
        if not rules and self.format != 1000:
            self.mark = f"%%{self.format + rng.randint(1, 10)}"
        elif rules:
            self.mark = f"%%{self.format}"
        rates = rng.choice(["m/min", "inch/min"] if self.format == 5000 else ["m/min"])
        self.setting = Setting("inch" if inch else "metric", "LZ" if self.leading else "TZ", (self.whole, self.decimals),
                               rates, rules)

    def digits(self, n, letter):
        """n units without a decimal point."""
        text = f"{abs(n):0{self.whole + self.decimals}d}"
        if not self.leading:
            text = str(abs(n))
        elif letter in "XY":
            text = text.rstrip("0") or "0"
        return ("-" if n < 0 else "") + text

    def length(self, n, letter="X", always_point=False):
        """A word of n units of the format's X, in one of its forms; H, K, Z have a unit of their own."""
        if self.format == 1000:
            return letter if n == 0 and self.rng.random() < 0.5 else letter + self.digits(n, letter)
        if n == 0 and self.rng.random() < 0.5:
            return letter + self.rng.choice(["", "0", "0.", "0.000"])
        mm = f"{n / 10 ** self.decimals:.{self.decimals}f}"
        if not always_point and self.rng.random() < 0.3:
            return letter + self.digits(n, letter)
        if self.rng.random() < 0.7:
            mm = mm.rstrip("0")
            mm = mm.replace("0.", ".", 1) if mm.startswith(("0.", "-0.")) and len(mm.split(".")[1]) else mm
        return letter + mm

    def plane(self, letter, mm):
        # A decimal point in any case: the unit differs by format.
        return letter + f"{mm / self.unit_mm:.{2 if self.unit_mm == 1 else 4}f}".rstrip("0")

    def feed(self):
        n = self.rng.randint(3, 40)  # 0.1 m/min
        if self.setting and self.setting.units == "inch" and self.setting.rates == "inch/min":
            return f"F{n * 4}."
        return f"F{n / 10:.1f}" if self.format == 5000 else f"F{n}"

    def pick(self, low_mm, high_mm):
        return self.rng.randint(round(low_mm / self.unit), round(high_mm / self.unit))

    def place(self):
        """A place in units, on a coarse grid now and then, so that zeros and equal axes occur."""
        if self.rng.random() < 0.3:
            return tuple(self.rng.randrange(-5, 30) * round(5 / self.unit) for _ in "xy")
        return (self.pick(-40, 200), self.pick(-40, 200))

    def xy(self, p):
        space = " " if self.rng.random() < 0.05 else ""
        return self.length(p[0], "X") + space + self.length(p[1], "Y")

    def comment(self):
        return " (HOLE 1)" if self.format != 1000 and self.rng.random() < 0.1 else ""

    # ---- states

    def state(self, tool=True):
        """The words that set every state."""
        rng = self.rng
        if tool:
            self.tool = rng.choice(sorted(self.diameters))
        words = f"T{self.tool}" if tool else ""
        if self.format >= 3000:
            words += rng.choice(["G82", "G83"])
        if self.format >= 3000 and self.planes_stated:
            words += self.plane("Z", rng.randint(0, 30) / 10) + self.plane("K", rng.randint(1, 30) / 10)
            words += self.plane("H", rng.randint(50, 90) / 10)
        if self.format == 5000:
            words += "G80G88"
        return words

    def some_words(self):
        """Words that a drilling line may carry."""
        rng = self.rng
        if self.format == 1000:
            return rng.choice(["", "", "", "M20", "M21"])
        words = rng.choice([""] * 10 + ["M20", "M21", "M28", "M29"])
        words += rng.choice([""] * 12 + ["G82", "G83", "G82", "G83", "G82G83", "G83G82"])
        if self.planes_stated:
            words += rng.choice([""] * 3 + [self.plane("Z", rng.randint(1, 30) / 10), self.plane("K", rng.randint(1, 20) / 10),
                                            self.plane("H", rng.randint(50, 90) / 10)])
        if self.format == 5000:
            again = ["G88G81"] if "G81I" in self.cycles else []
            words += rng.choice([""] * 12 + ["G88G81I5.P80J1.4W1000", "G80", "G80G89I5.J1.2E30R.2", "G88", "M94", "M95"] + again)
            self.cycles += words
        return words

    def new_tool(self):
        if self.rng.random() < 0.4 or self.tool is None:
            self.tool = self.rng.choice(sorted(self.diameters))
            return f"T{self.tool}"
        return ""

    # ---- drilling

    def holes(self):
        lines = []
        for _ in range(self.rng.randint(1, 5)):
            lines.append(self.xy(self.place()) + self.new_tool() + self.some_words() + self.comment())
        return lines

    def incremental_holes(self):
        rng = self.rng
        lines = [self.xy(self.place()) + self.new_tool()]
        for index in range(rng.randint(1, 4)):
            # Format 1000 needs G91 in every block.
            mark = "G91" if index == 0 or self.format == 1000 else ""
            lines.append(self.xy((self.pick(-10, 10), self.pick(-10, 10))) + mark)
        if rng.random() < 0.3 and self.format != 1000:
            lines += [self.xy((self.pick(-10, 10), self.pick(-10, 10))) + "T0",
                      self.xy((self.pick(1, 10), self.pick(-10, 10))) + "G1" + self.feed(), "T0"]
        return lines + [self.xy(self.place()) + "G90"]

    def row(self):
        rng = self.rng
        kinds = ["V2"] if self.format != 5000 else ["V2", "V3", "V4"]
        kind = rng.choice(kinds + ([] if self.moved else ["V1", "V1"]))
        p = self.place()
        first = self.xy(p) + kind + self.new_tool()
        n = rng.randint(2, 9)
        if kind in ("V1", "V3"):
            signs = [rng.choice([-1, 1]) for _ in "xy"]
            if rng.random() < 0.5:  # standard grid, up to 1 mm beside it
                steps = [rng.randint(1, 8) for _ in "xy"]
                q = tuple(a + s * round((k * 2.54 + rng.uniform(-1, 1)) / self.unit) for a, s, k in zip(p, signs, steps))
                return [first, self.xy(q)]
            pitch = self.pick(1, 4)
            along, across = (n - 1) * pitch, rng.randint(1, 4) * pitch
            if kind == "V3":
                across = along
            elif rng.random() < 0.5:
                across += round(pitch * rng.uniform(-0.3, 0.3))
            d = (along, across) if signs[0] * signs[1] < 0 else (across, along)
            return [first, self.xy((p[0] + signs[0] * d[0], p[1] + signs[1] * d[1])) + f"W{n}"]
        q = p
        while q == p:
            q = self.place()
        return [first, self.xy(q) + f"W{n}"]

    def nibble(self):
        if self.rng.random() < 0.5:
            return [self.xy(self.place()) + self.new_tool() + "G84" + self.length(self.pick(2.4, 6), "R", True)]
        p = self.place()
        return [self.xy(p) + self.new_tool() + "G85", self.xy((p[0] + self.pick(3, 20), p[1] + self.pick(-9, 9)))]

    def text(self):
        words = self.rng.choice(["A2341", "CNC", "B-7", "0"])
        return [self.xy(self.place()) + self.new_tool() + self.rng.choice(["M97,", "M98,"]) + words]

    # ---- routing

    def contour(self):
        rng = self.rng
        p = self.place()
        words = ["T0"] + ([self.new_tool()] if rng.random() < 0.7 else [])
        if self.tool is None:
            words = ["T0", self.new_tool()]
        rng.shuffle(words)
        lines = [self.xy(p) + "".join(words)]
        incremental = self.format != 1000 and rng.random() < 0.15
        side = rng.choice(["", "", "G41", "G42"])
        mode = None
        for index in range(rng.randint(1, 6)):
            q, line, code = self.move(p, mode, incremental)
            if index == 0:
                line += side + self.feed() + ("G91" if incremental else "")
            elif rng.random() < 0.1:
                line += self.feed()
            if self.format == 5000 and rng.random() < 0.05:
                line += "G11"
            if index > 0 and self.format >= 3000 and rng.random() < 0.1:
                line += rng.choice(["G40", "G41", "G42"])
            lines.append(line)
            p, mode = q, code
        if self.format >= 3000 and rng.random() < 0.1:
            lines[-1] += rng.choice(["M28", "M29"])
        end = self.place() if rng.random() < 0.1 else p
        return lines + [self.xy(end) + "T0" + ("G90" if incremental else "")]

    def move(self, p, mode, incremental):
        """One track from p: (end, line, code)."""
        rng = self.rng
        code = rng.choice([1, 1, 2, 3])
        word = f"G{code}" if code != mode or self.format == 1000 or rng.random() < 0.3 else ""
        if code == 1:
            q = p
            while q == p:
                q = (p[0] if rng.random() < 0.2 else self.pick(-40, 200), p[1] if rng.random() < 0.2 else self.pick(-40, 200))
            axes = self.axes(p, q, incremental)
            return q, axes + word, 1
        if self.format == 1000:
            return self.quadrant(p, code, word)
        if rng.random() < 0.5:
            scale, (a, b, c) = self.pick(0.5, 3), rng.choice(TRIPLES)
            start = (a * scale * rng.choice([-1, 1]), b * scale * rng.choice([-1, 1]))
            end = rng.choice([(-start[0], start[1]), (start[1], start[0]), (start[0], -start[1]), (-start[1], start[0]),
                              (c * scale, 0), (0, -c * scale), (-c * scale, 0)])
            q = (p[0] - start[0] + end[0], p[1] - start[1] + end[1])
            if q != p:
                return q, self.axes(p, q, incremental) + word + self.length(start[0], "I") + self.length(start[1], "J"), code
        q = (p[0] + self.pick(1, 20), p[1] + self.pick(-20, 20))
        chord = ((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2) ** 0.5
        radius = int(chord * rng.uniform(0.52, 2)) + 1
        return q, self.axes(p, q, incremental) + word + self.length(rng.choice([-1, 1]) * radius, "R"), code

    def quadrant(self, p, code, word):
        """Format 1000: a quarter of a circle or less, I and J without sign."""
        rng = self.rng
        scale, (a, b, c) = self.pick(0.5, 3), rng.choice(TRIPLES)
        start, end = rng.choice([((c, 0), (a, b)), ((a, b), (0, c)), ((c, 0), (0, c))])
        if code == 2:
            start, end = end, start
        for _ in range(rng.randrange(4)):
            start, end = (-start[1], start[0]), (-end[1], end[0])
        q = (p[0] + (end[0] - start[0]) * scale, p[1] + (end[1] - start[1]) * scale)
        return q, self.xy(q) + word + "".join(
            letter + self.digits(abs(a) * scale, letter) for letter, a in zip("IJ", start)), code

    def axes(self, p, q, incremental):
        if incremental:
            return self.xy((q[0] - p[0], q[1] - p[1]))
        if p[0] == q[0] and self.rng.random() < 0.5:
            return self.length(q[1], "Y")
        if p[1] == q[1] and self.rng.random() < 0.5:
            return self.length(q[0], "X")
        return self.xy(q)

    def rounded_contour(self):
        """Straight lines at right angles or slanted, and one arc, with D at corners."""
        rng = self.rng
        p, step = self.place(), self.pick(15, 30)
        lines = [self.xy(p) + "T0" + self.new_tool()]
        corners = rng.choice([[(1, 0), (1, 1), (0, 1)], [(2, 1), (1, 3), (0, 3)], [(1, 0), (2, 1), (2, 2)]])
        for index, (i, j) in enumerate(corners):
            line = self.xy((p[0] + i * step, p[1] + j * step)) + ("G1" + self.feed() if index == 0 else "")
            if index + 1 < len(corners):
                line += self.length(self.pick(0.5, 4), "D")
            lines.append(line)
        if rng.random() < 0.5:
            lines[-1] += self.length(self.pick(0.5, 2), "D")
            corners.append((corners[-1][0] - 1, corners[-1][1] + 2))
            lines.append(self.xy((p[0] + corners[-1][0] * step, p[1] + corners[-1][1] * step)) + "G3"
                         + self.length(2 * step, "R"))
        i, j = corners[-1]
        return lines + [self.xy((p[0] + i * step, p[1] + j * step)) + "T0"]

    def ramp(self):
        p, q = self.place(), self.place()
        if p == q or not self.planes_stated:
            return []
        start = self.plane("Z", self.rng.randint(15, 30) / 10)
        return [self.xy(p) + "T0" + self.new_tool() + "G82" + start,
                self.xy(q) + "G1" + self.feed() + "G6" + self.plane("Z", self.rng.randint(1, 14) / 10), self.xy(q) + "T0"]

    def depth_in_contour(self):
        if not self.planes_stated:
            return []
        p = self.place()
        lines = [self.xy(p) + "T0" + self.new_tool() + self.plane("G82Z", 2)]
        for index, words in enumerate(["G1" + self.feed(), self.plane("G83K", 1.2), "", "G82"]):
            p = (p[0] + self.pick(1, 20), p[1] + self.pick(-9, 9))
            lines.append(self.xy(p) + words)
        return lines + [self.xy(p) + "T0" + self.rng.choice(["", "G83", "G82"])]

    def figures(self):
        rng = self.rng
        codes = {1000: [49, 50], 3000: range(45, 51), 5000: range(45, 51)}[self.format]
        p = self.place()
        lines = [self.xy(p) + "T0" + self.new_tool()]
        for index in range(rng.randint(1, 3)):
            code = rng.choice(codes)
            if code < 49 or (self.format > 1000 and rng.random() < 0.4):
                size = self.length(self.pick(5, 25), "R")
            else:
                size = self.length(self.pick(8, 40), "I") + self.length(self.pick(8, 40), "J")
            if self.format == 5000 and code in (45, 46, 49, 50) and rng.random() < 0.2:
                size += "G43"
            lines.append(self.xy(self.place()) + f"G{code}" + size + (self.feed() if index == 0 else ""))
        return lines + [self.xy(self.place()) + "T0"]

    # ---- structure

    def quiet(self):
        lines = [""] if self.format == 1000 else ["(COMMENT)", "", "M47,TURN BOARD"]
        if self.format == 5000:
            lines += ["M49,NOFA", "M34", "M76,ABC", "M22", "M49,NORA"]
        if self.format == 5000 and self.nesting == 0 and not self.moved:  # panelcal refuses M56 in sections
            lines.append(self.xy(self.place()) + "M56")
        return [self.rng.choice(lines)]

    def labeled(self):
        """Lines with / under BLKD and NOBLKD, which panelcal refuses in subprograms."""
        if self.in_subprogram:
            return []
        line = "/" + self.xy(self.place())
        return ["M49,BLKD", line] if self.rng.random() < 0.5 else ["M49,NOBLKD", line]

    def without_lowering(self):
        """T0 within a drilling program: no hole; the next line drills again."""
        return [self.xy(self.place()) + "T0", self.xy(self.place())]

    def camera(self):
        """Measurements; the recorded ones of the test find each target in its place."""
        if self.nesting or self.moved:
            return []
        p = self.place()
        lines = ["M49,NOCAMA", "G34", self.xy(p) + "G32", self.xy((p[0] + self.pick(20, 90), p[1] + self.pick(-9, 9))) + "G32",
                 "G31", self.xy(self.place()) + self.new_tool()]
        return lines + [self.xy(self.place()) + "G36"] * self.rng.randint(0, 1) + ["G30"]

    def work(self):
        """Lines of one piece of work, outside of contours."""
        sized = self.figures if self.has_diameters else self.contour
        makers = [self.holes] * 4 + [self.incremental_holes, self.row, self.row, self.contour, self.contour, self.contour,
                                     sized, self.quiet, self.without_lowering]
        if self.format >= 3000:
            makers += [self.nibble, self.text] if self.has_diameters else [self.holes]
            makers += [self.rounded_contour, self.depth_in_contour]
        if self.format == 5000:
            makers += [self.ramp, self.call, self.call, self.surface, self.camera, self.labeled]
        return self.rng.choice(makers)()

    def section(self):
        """M31 .. M30 with offset lines, sections within."""
        if self.nesting >= 4:
            return []
        self.nesting += 1
        turned = self.moved
        copies = self.rng.choice(["none", "offsets", "offsets", "offsets", "row"])
        kinds = [self.rng.choice(OFFSETS) for _ in range(self.rng.randint(1, 3))]
        if self.rng.random() < 0.4 or copies != "offsets":
            kinds = ["M50"] * len(kinds)
        self.moved = turned or set(kinds) != {"M50"}
        opening = self.xy(self.place()) + (self.state() if self.rng.random() < 0.5 else self.new_tool())
        lines = [opening + "M31"] if self.rng.random() < 0.8 else ["M31", opening]
        if self.rng.random() < 0.2:  # two sections begin in one line
            self.nesting += 1
            lines[0] += "M31"
            lines += self.work() if self.nesting < 5 else []
            lines += self.end_of_section("offsets", ["M50"] * self.rng.randint(1, 2))
            self.nesting -= 1
        for _ in range(self.rng.randint(0, 2)):
            lines += self.section() if self.rng.random() < 0.25 else self.work()
        lines += self.end_of_section(copies, kinds)
        self.moved = turned
        self.nesting -= 1
        return lines

    def end_of_section(self, copies, kinds):
        if copies == "none":
            return [self.xy(self.place()) + "M30" if self.rng.random() < 0.5 else "M30"]
        if copies == "row":
            lines = [self.xy((0, 0)) + "M50V2", self.xy(self.place()) + f"M50W{self.rng.randint(2, 5)}"]
        else:
            lines = [self.xy(self.place()) + kind for kind in kinds]
        if self.format == 5000 and len(self.subprograms) < 5 and self.rng.random() < 0.2:
            return self.layout(lines)
        return lines[:-1] + [lines[-1] + "M30"]

    def layout(self, lines):
        """The offset lines in a subprogram of their own, moved by the zero of its call."""
        name = f"PANEL{len(self.subprograms)}"
        self.subprograms[name] = lines
        zero = self.rng.choice([self.xy(self.place()), ""])
        return self.rng.choice([[f"{zero}M99,{name}", "M30"], [f"{zero}M30M99,{name}"]])

    def call(self):
        """M99, with its zero at a coordinate or without."""
        if self.nesting >= 4 or len(self.subprograms) > 2:
            return []
        outer, self.in_subprogram = self.in_subprogram, True
        self.nesting += 1
        name = f"SUB{len(self.subprograms)}"
        self.subprograms[name] = []
        lines = [self.xy(self.place()) + self.state()]
        for _ in range(self.rng.randint(0, 2)):
            lines += self.section() if self.rng.random() < 0.3 else self.work()
        self.subprograms[name] = lines
        self.nesting -= 1
        self.in_subprogram = outer
        return [self.rng.choice([self.xy(self.place()), self.xy(self.place()), ""]) + f"M99,{name}"]

    def surface(self):
        """G71 .. G70 with probes; only where no section repeats it. Later work states its depth again."""
        if self.nesting or self.moved:
            return []
        lines = [self.plane("G82Z", 0.1), "G71"]  # a lower limit that no stroke reaches
        for _ in range(self.rng.randint(1, 2)):
            self.slm_memory += 1
            averaged = self.rng.random() < 0.3
            lines.append(self.xy(self.place()) + ("G73" if averaged else f"G73L{self.slm_memory}"))
            lines += [f"G74L{self.slm_memory}"] if averaged else []
        lines += ["G75", self.plane("G71K", self.rng.choice([0.4, -0.2, 1.1])), f"L{self.slm_memory}"]
        lines.append(self.xy(self.place()) + self.new_tool())
        p = self.place()
        lines += [self.xy(p) + "T0", self.xy((p[0] + 1000, p[1] - 500)) + "G1" + self.feed(), self.xy(p) + "T0", "G70"]
        return lines + [self.xy(self.place()) + self.plane("G83K", 0.7), self.xy(self.place()) + "G82"]

    def program(self):
        body = [self.xy(self.place()) + self.state()]
        style = self.rng.random()
        if self.format == 1000 and style < 0.6:
            body += self.implied_sections()
        elif style < 0.15:
            self.moved, self.nesting = True, 1
            for _ in range(self.rng.randint(1, 4)):
                body += self.work()
            body += [self.xy(self.place()) + self.rng.choice(OFFSETS) for _ in range(self.rng.randint(1, 3))]
        else:
            for _ in range(self.rng.randint(2, 6)):
                body += self.section() if self.format > 1000 and self.rng.random() < 0.4 else self.work()
        lines = (["RANDOM PROGRAM"] if self.rng.random() < 0.3 else []) + [self.mark] + body + self.tools()
        long = [line for line in lines if len(line) > 64 and not line.startswith("$")]
        assert not long, long
        end = self.rng.choice(["\n", "\n", "\r\n", "\r"])
        subprograms = "".join(f"@{name}\n" + "".join(line + "\n" for line in lines)
                              for name, lines in self.subprograms.items())
        return end.join(lines) + end, subprograms

    def implied_sections(self):
        """Format 1000: a section ends with M30 and begins behind the last one."""
        body = []
        for index in range(self.rng.randint(1, 3)):
            kinds = [self.rng.choice(OFFSETS) for _ in range(self.rng.randint(1, 3))]
            self.moved = set(kinds) != {"M50"}
            if index:
                body.append(self.xy(self.place()) + self.state())
            for _ in range(self.rng.randint(0, 2)):
                body += self.work()
            body += [self.xy(self.place()) + kind for kind in kinds]
            body[-1] += "M30"
        self.moved = False
        return body

    def tools(self):
        if self.format == 1000:
            sizes = {tool: self.digits(round(d / 100 / self.unit), "D") for tool, d in self.diameters.items()}
            return ["$" + "".join(f"{sizes.get(tool, '')}$40$20$99$30$$" for tool in range(1, 16))]
        lines = ["$"]
        for tool, diameter in sorted(self.diameters.items()):
            if self.setting:
                size = f"D{diameter / 100 / self.unit_mm:.4f}" if self.has_diameters else ""
                point = "." if self.format == 5000 else ""
                lines.append(f"T{tool}{size}S40F20{point}R99{point}N30")
                continue
            lines.append(f"T{tool}D{diameter}S40F20R99N30" if self.format == 3000 else f"T{tool}D{diameter / 100:.2f}S40F2.R9.9N3000")
        return lines + ["$"]
