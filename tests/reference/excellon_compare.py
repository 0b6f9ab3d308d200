# SPDX-License-Identifier: Apache-2.0
"""Comparison of panelcal's operations (docs/formats/operations.md) with those of the reading from the manual.

Where the manual leaves room the comparison holds panelcal to what the manual does say: a package's holes in any
order, a ring that may begin anywhere, a routed circle that may begin at its top or bottom. Letters come from docs/font.md.
"""
from fractions import Fraction
import json
import math
from pathlib import Path
import re

from excellon.drilling import ring_holes_needed, slot_pitch_limit_mm

ROOT = Path(__file__).resolve().parents[2]
# Coordinates have six decimals: half of the last one, and what doubles lose.
RESOLUTION_MM = 1e-6
INCH_MM = 25.4
# Operations of panelcal that move no tool and that the reading does not list.
OTHER = {'setting', 'function', 'zero_set'}
STOPS = {'M00': 'end', 'M30': 'end_rewind', 'M06': 'optional', 'M09': 'inspection'}


class Difference(Exception):
    """The first place at which the two readings differ."""


class Output:
    """panelcal's operations, one at a time, with the tool and the compensation in force."""

    def __init__(self, text, center_mm):
        self.operations = [json.loads(line) for line in text.splitlines()]
        self.center_mm = center_mm
        self.at = 0
        self.tool, self.compensation = {}, None
        self.checked = None  # tool and expected operation that agreed last

    def skip(self):
        """Passes what sets a state or moves nothing."""
        while self.at < len(self.operations):
            operation = self.operations[self.at]
            kind = operation['op']
            if kind == 'tool':
                self.tool = operation
            elif kind == 'rate':
                self.tool = {**self.tool, **{key: operation[key] for key in ('feed', 'retract') if key in operation}}
            elif kind == 'compensation':
                self.compensation = (operation['side'], operation['value']) if operation['side'] != 'off' else None
            elif kind not in OTHER and not (kind == 'stop' and operation['kind'] == 'header_end'):
                return
            self.at += 1

    def take(self, kind, expected):
        """The next operation, which must be of this kind and of the expected place in the program."""
        self.skip()
        if self.at == len(self.operations):
            raise Difference(f'nothing more; expected {describe(expected)}')
        operation = self.operations[self.at]
        self.at += 1
        if operation['op'] != kind:
            raise Difference(f'{json.dumps(operation)}; expected {describe(expected)}')
        same(operation['line'], expected.line, 'line', operation, expected)
        same(Path(operation['file']).name if 'file' in operation else None, expected.file, 'file', operation, expected)
        same(operation.get('path'), list(expected.path) if expected.path else None, 'path', operation, expected)
        if expected.tool and kind != 'retract' and kind != 'position':
            same(operation['tool'], expected.tool.number, 'tool', operation, expected)
            self.check_tool(operation, expected)
        if kind == 'position':
            self.compensation = None
        return operation

    def check_tool(self, operation, expected):
        if self.checked is not None and self.checked[0] is self.tool and self.checked[1] is expected:
            return
        tool = expected.tool
        wanted = {'tool': tool.number, 'diameter': tool.diameter_mm, 'feed': tool.feed_mm_s, 'speed': tool.speed_rpm,
                  'retract': tool.retract_mm_s, 'max_hits': tool.max_hits, 'depth_offset': tool.depth_offset_mm}
        for key, value in wanted.items():
            near(self.tool.get(key), value, f'tool {key}', operation, expected)
        self.checked = (self.tool, expected)


def describe(expected):
    return json.dumps(expected.as_json())


def same(got, wanted, what, operation, expected):
    if got != wanted:
        raise Difference(f'{what} {got}, expected {wanted}: {json.dumps(operation)}; expected {describe(expected)}')


def near(got, wanted, what, operation, expected, tolerance=RESOLUTION_MM):
    """Equal numbers within a tolerance; None is near None only."""
    if (got is None) != (wanted is None) or (got is not None and not abs(got - float(wanted)) <= tolerance):
        shown = None if wanted is None else float(wanted)
        raise Difference(f'{what} {got}, expected {shown}: {json.dumps(operation)}; expected {describe(expected)}')


def place(operation, point, expected, suffix=''):
    """Nominal place relative to work zero, actual place with it."""
    for i in range(2):
        wanted = float(point[i])
        near(operation['nominal' + suffix][i], wanted, 'nominal' + suffix, operation, expected)
        near(operation['actual' + suffix][i], wanted + float(expected.zero_mm[i]), 'actual' + suffix, operation, expected)


def holes_in_any_order(output, points, expected):
    left = [tuple(map(float, point)) for point in points]
    while left:
        operation = output.take('drill', expected)
        at = operation['nominal']
        found = next((i for i in (0, -1) if math.dist(left[i], at) < RESOLUTION_MM), None)
        if found is None:
            found = min(range(len(left)), key=lambda i: math.dist(left[i], at))
        place(operation, left.pop(found), expected)


def ring(output, expected):
    """Evenly spaced holes on the ring, the fewest whose protrusions are below 0.0005 inch."""
    hole, drill = expected.values['hole_diameter_mm'], expected.tool.diameter_mm
    drill = drill or Fraction(125, 1000) * Fraction(127, 5)
    count = ring_holes_needed(hole, drill)
    (cx, cy), radius = map(float, expected.points[0]), float(expected.values['ring_radius_mm'])
    output.skip()
    x, y = output.operations[output.at].get('nominal', (cx, cy))
    start = math.atan2(y - cy, x - cx)
    angles = [start + 2 * math.pi * i / count for i in range(count)]
    holes_in_any_order(output, [(cx + radius * math.cos(a), cy + radius * math.sin(a)) for a in angles], expected)


def slot(output, expected, expand):
    """A slot left whole, or its holes: adjacent ones first, then passes between them until the pitch is fine enough."""
    start, end = (tuple(map(float, point)) for point in expected.points)
    if not expand:
        operation = output.take('slot', expected)
        place(operation, expected.points[0], expected)
        place(operation, expected.points[1], expected, '_end')
        return
    drill = float(expected.tool.diameter_mm)
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    # "Adjacent" holes may touch or nearly touch: the whole numbers next to length / diameter.
    output.skip()
    second = output.operations[output.at + 1].get('nominal', start) if output.at + 1 < len(output.operations) else start
    pitch = math.hypot(second[0] - start[0], second[1] - start[1]) or length
    count = max(1, min((math.floor(length / drill), math.ceil(length / drill)), key=lambda n: abs(n * pitch - length)))
    numbers = list(range(count + 1))
    while length / count >= slot_pitch_limit_mm(drill):
        count *= 2
        numbers = [2 * n for n in numbers] + list(range(1, count, 2))
    for n in numbers:
        t = n / count
        place(output.take('drill', expected), tuple(s + (e - s) * t for s, e in zip(start, end)), expected)


def font():
    """{character: rows of the 4 x 7 grid from the top} of docs/font.md, section excellon."""
    section = re.search(r'^## excellon\n(.*?)(?=^## |\Z)', (ROOT / 'docs/font.md').read_text(), re.M | re.S)[1]
    glyphs = {}
    for block in re.findall(r'^```\n(.*?)^```', section, re.M | re.S):
        lines = block.split('\n')
        starts = [match.start() for match in re.finditer(r'\S', lines[0])]
        for start in starts:
            glyphs[lines[0][start]] = [line[start:start + 4] for line in lines[2:9]]
    return glyphs


def text(output, expected, glyphs):
    """Characters five columns apart, drilled column by column, up and down in turn (docs/font.md)."""
    (x, y), right, up = expected.points
    for i, character in enumerate(expected.values['text']):
        if character == ' ':
            continue
        for column in range(4):
            rows = range(7) if column % 2 == 0 else range(6, -1, -1)
            for row in rows:
                if glyphs[character][6 - row][column] == '#':
                    along = 5 * i + column
                    point = (x + right[0] * along + up[0] * row, y + right[1] * along + up[1] * row)
                    place(output.take('drill', expected), point, expected)


def rout(output, expected, kind, end, centre=None, feed=None):
    operation = output.take('rout', expected)
    same(operation['kind'], kind, 'kind', operation, expected)
    place(operation, end, expected)
    if centre:
        for i in range(2):
            near(operation['center'][i], centre[i] + expected.zero_mm[i], 'center', operation, expected, output.center_mm)
    if feed is not None:
        near(operation['feed'], feed, 'feed', operation, expected)
    return operation


def contour_move(output, expected):
    compensation = expected.values['compensation']
    got = output.compensation
    if (got is None) != (compensation is None) or (got and got[0] != compensation[0]):
        raise Difference(f'compensation {got}; expected {describe(expected)}')
    if got:
        near(got[1], compensation[1], 'compensation value', {}, expected)
    centre = expected.points[2] if expected.kind == 'arc' else None
    kind = 'line' if expected.kind == 'line' else 'cw' if expected.values['clockwise'] else 'ccw'
    rout(output, expected, kind, expected.points[1], centre, expected.values['feed_mm_s'])


def routed_circle(output, expected):
    """The sequence of "Routed Circle Canned Cycle": plunge 0.01 inch off the edge, half arcs, retract 0.1 inch off."""
    (cx, cy), radius = map(float, expected.points[0]), float(expected.values['path_radius_mm'])
    kind = 'cw' if expected.values['clockwise'] else 'ccw'
    start = output.take('position', expected)
    dx, dy = start['nominal'][0] - cx, start['nominal'][1] - cy
    # The manual's Y2 and Y1 say that the turning points differ in y only; a swapped copy has them in x.
    along = (math.copysign(1, dx), 0.0) if abs(dx) > abs(dy) else (0.0, math.copysign(1, dy))
    near_edge = radius - 0.01 * INCH_MM
    place(start, (cx + along[0] * near_edge, cy + along[1] * near_edge), expected)
    output.take('plunge', expected)
    here = start['nominal']
    for i, side in enumerate((-1, 1, -1)):
        end = (cx + side * along[0] * radius, cy + side * along[1] * radius)
        arc = rout(output, expected, kind, end, (cx, cy) if i else None)
        has_radius(arc, here, radius, expected)
        here = arc['nominal']
    output.skip()
    end = output.operations[output.at].get('nominal', here)
    # 0.1 inch off the edge is beyond the centre of a small circle, or outside: anywhere on the far half will do.
    far = 0.1 * INCH_MM - radius
    if far > 0:
        far = max(-radius, min(far, (end[0] - cx) * along[0] + (end[1] - cy) * along[1]))
    arc = rout(output, expected, kind, (cx + along[0] * far, cy + along[1] * far))
    has_radius(arc, here, radius, expected)
    output.take('retract', expected)


def has_radius(arc, start, radius, expected):
    """The arc's ends are at the radius from its centre, within what rounded coordinates lose."""
    centre = [arc['center'][i] - float(expected.zero_mm[i]) for i in range(2)]
    for point in (start, arc['nominal']):
        if not abs(math.dist(point, centre) - radius) < 10 * RESOLUTION_MM:
            raise Difference(f'radius {math.dist(point, centre)}, expected {radius}: {json.dumps(arc)}')


def step_slot(output, expected, expand):
    passes = expected.values['passes']
    if not expand:
        operation = output.take('step_slot', expected)
        place(operation, expected.points[0], expected)
        place(operation, expected.points[1], expected, '_end')
        near(operation['initial_depth'], passes[0], 'initial_depth', operation, expected)
        near(operation['increment'], expected.values['increment_mm'], 'increment', operation, expected)
        return
    place(output.take('position', expected), expected.points[0], expected)
    base = expected.tool.depth_offset_mm or 0
    for i, above in enumerate(passes):
        plunge = output.take('plunge', expected)
        near(plunge['depth_offset'], base + above, 'depth_offset', plunge, expected)
        rout(output, expected, 'line', expected.points[1 - i % 2])
    output.take('retract', expected)


def event(output, expected):
    """Stops, dwells and messages."""
    if expected.kind == 'stop':
        operation = output.take('stop', expected)
        same(operation['kind'], STOPS[expected.values['code']], 'kind', operation, expected)
        same('actual' in operation, bool(expected.points), 'a place', operation, expected)
        for point in expected.points:
            for i in range(2):
                near(operation['actual'][i], point[i], 'actual', operation, expected)
    elif expected.kind == 'dwell':
        operation = output.take('dwell', expected)
        milliseconds = expected.values['increments']
        wanted = milliseconds / 1000 if 1000 <= milliseconds <= 10000 else 10
        near(operation['time'], wanted, 'time', operation, expected)
    else:
        operation = output.take('message', expected)
        same(operation['text'], expected.values['text'], 'text', operation, expected)


def compare(operations, output_text, expand, glyphs, center_mm=RESOLUTION_MM):
    """Raises Difference at the first place at which panelcal's output is not what the operations say.

    `center_mm`: how far off the centres of arcs may be. Where ends and centre are rounded, one of them is not on the circle.
    """
    output = Output(output_text, center_mm)
    for expected in operations:
        kind = expected.kind
        if kind in ('hole', 'position'):
            place(output.take('drill' if kind == 'hole' else kind, expected), expected.points[0], expected)
        elif kind == 'holes':
            holes_in_any_order(output, expected.points, expected)
        elif kind == 'ring':
            ring(output, expected)
        elif kind == 'slot':
            slot(output, expected, expand)
        elif kind == 'text':
            text(output, expected, glyphs)
        elif kind == 'plunge':
            wanted = 'contouring' if expected.values['contoured'] else 'plain'
            operation = output.take('plunge', expected)
            same(operation['kind'], wanted, 'kind', operation, expected)
        elif kind in ('line', 'arc'):
            contour_move(output, expected)
        elif kind == 'retract':
            output.take('retract', expected)
        elif kind == 'routed-circle':
            routed_circle(output, expected)
        elif kind == 'step-slot':
            step_slot(output, expected, expand)
        else:
            event(output, expected)
    output.skip()
    if output.at != len(output.operations):
        raise Difference(f'more than expected: {json.dumps(output.operations[output.at])}')
