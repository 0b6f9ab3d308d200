# SPDX-License-Identifier: Apache-2.0
"""Compares the operations of this reading with the JSON Lines that `panelcal run` writes.

Both lists become the same events: holes, plunges (the tool goes down to rout), moves and retracts.
panelcal writes figures (G45 .. G50, G84, texts) as the moves and holes that make them; the manual gives
their geometry, not each move, so that a figure is held against what the manual gives of it.
"""

import dataclasses
import json
import math
import re
from typing import Optional

from .contours import sweep

# panelcal writes six decimals: each side's rounding.
TOLERANCE_MM = 1.1e-6
# A center follows from two written places and a radius; its error grows with radius / chord.
CENTER_TOLERANCE_MM = 1e-5
# manual: plunge points are computed with 0.707 and 1.707, three digits of a radius up to 50 mm.
PLUNGE_TOLERANCE_MM = 0.02
WRITTEN_TOLERANCE_MM = 0.00075
# Both halves of a circle have rounded ends, and each its own centre as far from both.
WRITTEN_CENTER_TOLERANCE_MM = 0.002
IGNORED = {"tool", "stop", "message", "function", "setting", "dwell", "rate", "zero_set"}


class Difference(Exception):
    """The two readings of a program differ."""


@dataclasses.dataclass
class Depths:
    """What JSON Lines state of a stroke's depth; None is the operator's value."""

    control: Optional[str]  # "depth" (G83), "slm" (G71)
    z: Optional[float]
    depth: Optional[float]
    surface: Optional[float]
    lower_limit: Optional[float]
    upper_limit: Optional[float]

    @classmethod
    def of(cls, record):
        return cls(**{field.name: record.get(field.name) for field in dataclasses.fields(cls)})

    def agrees_with(self, depth, tolerance=TOLERANCE_MM):
        """`depth` is that of the second reading."""
        control = {"table": None, "board": "depth", "surface": "slm"}[depth.reference]
        if control is None:
            stated = (self.z, self.depth, self.lower_limit, self.upper_limit)
            wanted = (depth.depth_mm, None, None, depth.upper_mm)
        else:
            stated = (self.depth, self.z, self.lower_limit, self.upper_limit)
            wanted = (depth.depth_mm, None, depth.lower_mm, depth.upper_mm)
        same = all((a is None) == (b is None) and (a is None or abs(a - b) <= tolerance)
                   for a, b in zip(stated, wanted))
        return self.control == control and same


@dataclasses.dataclass
class Event:
    kind: str  # hole, plunge, line, arc, slot, retract
    line: int
    path: tuple
    tool: Optional[int] = None
    start: Optional[tuple] = None
    at: Optional[tuple] = None  # the hole, the place of a plunge, the end of a move
    center: Optional[tuple] = None
    clockwise: Optional[bool] = None
    turned_rad: float = 0.0
    compensation: Optional[str] = None
    feed_mm_s: Optional[float] = None
    depth: Optional["Depths"] = None
    cycle: Optional[tuple] = None


class Cycles:
    """Peck and pulse drilling as panelcal passes them on, before the holes they hold for."""

    def __init__(self):
        self.on = {"peck": False, "pulse": False}
        self.values = {"peck": {}, "pulse": {}}

    def read(self, record):
        text = record.get("text", "")
        name, _, state = record.get("kind", "").partition("_")
        if name in self.on:
            self.on[name] = state == "on"
            for letter, number in re.findall(r"([A-Z])([0-9.]+)", text)[1:]:
                self.values[name][letter] = float(number)
            # manual: "G81": pulse drilling and peck drilling cannot be used at the same time.
            if self.on["peck"] and self.on["pulse"]:
                raise Difference(f"line {record['line']}: G81 and G89 at the same time")

    def cycle(self):
        name = next((name for name, on in self.on.items() if on), None)
        return name and (name, tuple(sorted(self.values[name].items())))


def events_of_panelcal(text, splits=False):
    """The events of operations in JSON Lines (docs/formats/operations.md).

    splits  Another depth within a contour is a plunge: a written program ends the contour there and begins another.
    """
    events = []
    place, down, side = None, False, None
    cycles = Cycles()
    for record in map(json.loads, text.splitlines()):
        op = record["op"]
        where = (record["line"], (record.get("file"), *record.get("path", ())))
        cycles.read(record)
        depth = Depths.of(record)
        at = tuple(record["nominal"]) if "nominal" in record else None
        if op == "drill":
            events.append(Event("hole", *where, record["tool"], at=at, depth=depth, cycle=cycles.cycle()))
        elif op == "slot":
            end = tuple(record["nominal_end"])
            events.append(Event("slot", *where, record["tool"], start=at, at=end, depth=depth))
            at = end
        elif op == "position":
            down, side = False, None
        elif op == "compensation":
            side = None if record["side"] == "off" else record["side"]
        elif op == "plunge":
            if not down or splits:  # Within a contour: only another depth.
                events.append(Event("plunge", *where, record["tool"], at=place, depth=depth))
            down = True
        elif op == "rout":
            if not down:
                raise Difference(f"{where}: panelcal routs with the tool up")
            move = Event("line", *where, record["tool"], start=place, at=at, compensation=side,
                         feed_mm_s=record["feed"], depth=depth)
            if record["kind"] != "line":
                move.kind, move.clockwise = "arc", record["kind"] == "cw"
                move.center = tuple(record["center"])
                move.turned_rad = sweep(move.center, place, at, move.clockwise)
            add_move(events, move)
        elif op == "retract":
            if down:
                events.append(Event("retract", *where))
            down = False
        elif op not in IGNORED:
            raise Difference(f'{where}: no event for "{op}"')
        place = at or place
    return events


def add_move(events, move):
    """panelcal divides arcs of more than half a circle."""
    last = events[-1] if events else None
    same = (last is not None and move.kind == "arc" == last.kind and move.center == last.center
            and (move.line, move.path, move.clockwise) == (last.line, last.path, last.clockwise))
    if same:
        last.at = move.at
        last.turned_rad += move.turned_rad
    else:
        events.append(move)


class Comparison:
    """Walks through both lists side by side."""

    def __init__(self, operations, events, diameters_mm):
        self.operations = operations
        self.events = events
        self.diameters = diameters_mm
        self.index = 0
        self.counts = {}  # kind -> operations that were compared

    def run(self):
        """Raises Difference at the first operation that is not the same on both sides."""
        row = []
        after_figure = False
        for operation in self.operations:
            if operation.kind in ("measure", "probe"):
                continue
            self.counts[operation.kind] = self.counts.get(operation.kind, 0) + 1
            if operation.kind == "retract" and after_figure:
                continue  # panelcal has retracted behind the figure
            after_figure = operation.kind in ("circle", "rectangle")
            if operation.pattern:
                row.append(operation)
                if len(row) == operation.pattern[2]:
                    self.compare_row(row)
                    row = []
            else:
                getattr(self, "compare_" + operation.kind)(operation)
        if self.index != len(self.events):
            raise Difference(f"panelcal does more: {self.events[self.index]}")
        return self.counts

    # ---- one event

    def next(self, operation, kind):
        if self.index == len(self.events):
            raise Difference(f"panelcal does less: {operation}")
        event = self.events[self.index]
        self.index += 1
        self.expect(operation, event, event.kind == kind, f"kind {kind}")
        self.expect(operation, event, event.line == operation.line, "line")
        if kind != "retract":
            self.expect(operation, event, event.tool == operation.tool, "tool")
            self.compare_depth(operation, event)
        return event

    def expect(self, operation, event, condition, what):
        if not condition:
            raise Difference(f"{what} differs\n  manual   {operation}\n  panelcal {event}")

    def near(self, operation, event, a, b, what, tolerance=TOLERANCE_MM):
        self.expect(operation, event, math.dist(a, b) <= tolerance * math.sqrt(2), f"{what} {a}, {b}:")

    def compare_depth(self, operation, event):
        self.expect(operation, event, event.depth.agrees_with(operation.depth), "depth")
        if operation.depth.reference == "surface" and operation.depth.depth_mm is not None:
            self.expect(operation, event, event.depth.surface is not None, "surface")

    # ---- operations

    def compare_hole(self, operation):
        event = self.next(operation, "hole")
        self.near(operation, event, operation.at, event.at, "place")
        self.expect(operation, event, operation.cycle == event.cycle, "cycle")

    def compare_row(self, row):
        """Holes of a row whose order the manual leaves open; the count and each place must agree."""
        left = [operation.at for operation in row]
        for operation in row:
            event = self.next(operation, "hole")
            nearest = min(left, key=lambda place: math.dist(place, event.at))
            self.near(operation, event, nearest, event.at, "place in a row")
            left.remove(nearest)

    def compare_plunge(self, operation):
        event = self.next(operation, "plunge")
        self.near(operation, event, operation.at, event.at, "place")

    def compare_retract(self, operation):
        self.next(operation, "retract")

    def compare_line(self, operation):
        event = self.next(operation, "line")
        self.compare_move(operation, event)

    def compare_move(self, operation, event):
        self.near(operation, event, operation.start, event.start, "start")
        self.near(operation, event, operation.end, event.at, "end")
        self.expect(operation, event, operation.compensation == event.compensation, "compensation")
        self.compare_feed(operation, event)

    def compare_feed(self, operation, event):
        if operation.feed_m_min is not None:
            same = abs(operation.feed_m_min * 1000 / 60 - event.feed_mm_s) <= 1e-5
            self.expect(operation, event, same, "feed")

    def compare_arc(self, operation):
        event = self.next(operation, "arc")
        self.compare_move(operation, event)
        self.near(operation, event, operation.center, event.center, "center", CENTER_TOLERANCE_MM)
        self.expect(operation, event, operation.clockwise == event.clockwise, "direction")
        turn = sweep(operation.center, operation.start, operation.end, operation.clockwise)
        self.expect(operation, event, abs(turn - event.turned_rad) < 1e-4, f"angle {turn}")

    def compare_nibble_slot(self, operation):
        event = self.next(operation, "slot")
        self.near(operation, event, operation.start, event.start, "start")
        self.near(operation, event, operation.end, event.at, "end")

    def compare_nibble_circle(self, operation):
        """manual: G84: a hole of this radius is made of holes with the tool's diameter, all round."""
        reach = operation.radius - self.diameters[operation.tool] / 2
        angles = []
        while self.index < len(self.events) and self.same_figure(operation):
            event = self.next(operation, "hole")
            offset = (event.at[0] - operation.center[0], event.at[1] - operation.center[1])
            self.expect(operation, event, abs(math.hypot(*offset) - reach) <= 2 * TOLERANCE_MM, f"radius {reach}")
            angles.append(math.atan2(offset[1], offset[0]))
        angles.sort()
        gaps = [b - a for a, b in zip(angles, angles[1:] + [a + 2 * math.pi for a in angles[:1]])]
        tool = self.diameters[operation.tool]
        if not angles or max(gaps) * reach > tool:
            raise Difference(f"the holes of a nibbled circle do not meet: {operation}")

    def same_figure(self, operation):
        event = self.events[self.index]
        return event.kind == "hole" and event.line == operation.line and math.dist(
            event.at, operation.center) < operation.radius

    def compare_text(self, operation):
        """The characters are the maker's own; the first line of dots begins at the coordinate."""
        first = self.events[self.index] if self.index < len(self.events) else None
        along, count = operation.direction, 0
        while self.index < len(self.events):
            event = self.events[self.index]
            if event.kind != "hole" or (event.line, event.path) != (operation.line, first.path):
                break
            self.next(operation, "hole")
            offset = (event.at[0] - operation.at[0], event.at[1] - operation.at[1])
            forward = offset[0] * along[0] + offset[1] * along[1]
            aside = abs(offset[1] * along[0] - offset[0] * along[1])
            pitch = 1.2 * self.diameters[operation.tool]  # manual: "Character matrix"
            # Variables (& and a letter, *) become texts of other lengths.
            n = 100 if set("&*") & set(operation.string) else len(operation.string)
            inside = -1e-6 < forward < pitch * (6 * n - 1) and aside < 6 * pitch + 1e-6
            self.expect(operation, event, inside, "text")
            count += 1
        if count == 0:
            raise Difference(f"a text without holes: {operation}")

    # ---- finished contours

    def figure(self, operation):
        """Moves of a figure, from its plunge to its retract."""
        plunge = self.next(operation, "plunge")
        self.near(operation, plunge, operation.plunge, plunge.at, "plunge point", PLUNGE_TOLERANCE_MM)
        moves = []
        while self.index < len(self.events) and self.events[self.index].kind in ("line", "arc"):
            moves.append(self.next(operation, self.events[self.index].kind))
            self.compare_feed(operation, moves[-1])
        self.next(operation, "retract")
        return moves

    def compare_circle(self, operation):
        """The whole circle is routed in the direction of the command, half a cutter beside it."""
        moves = self.figure(operation)
        half = self.diameters[operation.tool] / 2
        reach = operation.radius - half if operation.inside else operation.radius + half
        turned = sum(move.turned_rad for move in moves
                     if move.kind == "arc" and move.clockwise == operation.clockwise
                     and math.dist(move.center, operation.center) <= 2 * TOLERANCE_MM
                     and abs(math.dist(move.at, operation.center) - reach) <= 4 * TOLERANCE_MM)
        if abs(turned - 2 * math.pi) > 1e-4:
            raise Difference(f"{turned} rad of the circle are routed: {operation}")

    def compare_rectangle(self, operation):
        """All corners, half a cutter inside, in the direction of the command."""
        moves = self.figure(operation)
        half = self.diameters[operation.tool] / 2
        a, b = operation.size[0] / 2 - half, operation.size[1] / 2 - half
        corners = [(-a, -b), (-a, b), (a, b), (a, -b)]  # clockwise
        visited = []
        for move in moves:
            offset = (move.at[0] - operation.center[0], move.at[1] - operation.center[1])
            visited += [k for k, corner in enumerate(corners) if math.dist(corner, offset) <= 3 * TOLERANCE_MM]
        turns = {(j - i) % 4 for i, j in zip(visited, visited[1:])}
        if len(set(visited)) != 4 or turns != ({1} if operation.clockwise else {3}):
            raise Difference(f"corners {visited} (clockwise from the lower left) of {operation}")


def compare_written(operations, events):
    """The operations of a program that panelcal has written against the events of its JSON Lines.

    Places are those that a control reads from the written numbers: 1 um apart, so half of it beside.
    """
    kinds = {"hole": "hole", "plunge": "plunge", "line": "line", "arc": "arc", "nibble_slot": "slot"}
    written = [operation for operation in operations if operation.kind != "retract"]
    events = [event for event in events if event.kind != "retract"]
    whole = []
    for operation in written:
        if operation.kind not in kinds:
            raise Difference(f"panelcal does not write this by itself: {operation}")
        before = whole[-1] if whole else None
        if (before is not None and operation.kind == before.kind == "arc" and operation.clockwise == before.clockwise
                and math.dist(operation.center, before.center) <= WRITTEN_CENTER_TOLERANCE_MM
                and operation.start == before.end):
            whole[-1] = dataclasses.replace(before, end=operation.end)
        else:
            whole.append(operation)
    if len(whole) != len(events):
        raise Difference(f"{len(whole)} operations are written, {len(events)} are in JSON Lines")
    for operation, event in zip(whole, events):
        places = [(operation.at or operation.end, event.at), (operation.start, event.start)]
        near = all(a is None or b is None or math.dist(a, b) <= WRITTEN_TOLERANCE_MM for a, b in places)
        same = (kinds[operation.kind], operation.tool, operation.clockwise, operation.compensation) == (
            event.kind, event.tool, event.clockwise, event.compensation)
        if not near or not same or not event.depth.agrees_with(operation.depth, WRITTEN_TOLERANCE_MM):
            raise Difference(f"written otherwise than in JSON Lines\n  written    {operation}\n  JSON Lines {event}")
    return len(whole)
