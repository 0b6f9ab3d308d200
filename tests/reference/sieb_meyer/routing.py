# SPDX-License-Identifier: Apache-2.0
"""T0 lines, contours and their moves. manual: chapter 3 and "The T0 command"."""

from . import geometry
from .operations import Operation
from .reader import Refusal, codes, last

MOTIONS = {1, 2, 3, 45, 46, 47, 48, 49, 50}
CAMERA = {30, 31, 32, 33, 34, 36}


class Routing:
    """The part of the interpreter that routs; it uses the modal state, target() and operation()."""

    def run_t0(self, block, placed):
        """manual: "The T0 command": the table moves with a retracted Z-axis; a contour begins or ends."""
        modal = self.modal
        if set(codes(block, "G")) & (CAMERA | {6, 11, 41, 42, 43, 84, 85, 73, 78, 79}):
            raise Refusal(block.line, "T0 and a working command on one line")
        if modal.contour == "routing":
            position = self.target(block, False) if placed else modal.position
            operations = self.end_contour(block.line)
            modal.position = position
            return operations
        if modal.contour == "left":
            modal.position, modal.contour = self.target(block, False) if placed else modal.position, ""
            return []
        modal.position = self.target(block, True) if placed else modal.position
        if modal.position is None or not placed:
            raise Refusal(block.line, "T0 at the beginning of a contour needs X and Y")
        modal.contour = "positioned"
        modal.compensation = None
        return []

    def end_contour(self, line):
        modal = self.modal
        operations = []
        if modal.contour == "routing":
            operations.append(self.operation("retract", line, at=modal.position))
        modal.contour, modal.motion, modal.routed, modal.compensation = "", None, False, None
        return operations

    def route(self, block, motion, g, before):
        modal = self.modal
        line = block.line
        if modal.contour in ("", "left"):
            raise Refusal(line, "a contour must begin with T0, also behind M28 and M29")
        if {73, 78, 79, 84, 85} & set(g) or codes(block, "V") or block.command:
            raise Refusal(line, "a drilling command within a contour")
        motion = motion or modal.motion
        if modal.motion is not None and (motion < 10) != (modal.motion < 10):
            raise Refusal(line, "tracks and finished contours in one contour")
        start = modal.position
        end = self.target(block, motion > 10)
        if modal.routed and start == end:
            raise Refusal(line, "two program lines with identical rout coordinates")  # manual: chapter 3
        fields = {"feed_m_min": modal.feed_m_min}
        if last(block, "D"):
            fields["round_mm"] = self.positive(block, "D")
        if 6 in g:
            if modal.board or modal.slm or last(block, "Z") is None or motion > 10:
                raise Refusal(line, "G6 needs Z, a track and G82")
            fields["ramp_from"] = before
        operations = []
        if motion < 10:
            if modal.contour == "positioned":
                # A ramp begins at the depth that held before its line.
                plunge = self.operation("plunge", line, at=start)
                operations.append(plunge if 6 not in g else Operation("plunge", line, modal.tool, before, at=start))
            operations.append(self.track(line, motion, start, end, g, fields))
        else:
            operations.append(self.finished_contour(line, motion, end, g, fields))
        modal.contour, modal.motion, modal.routed, modal.position = "routing", motion, True, end
        if {28, 29} & set(codes(block, "M")):
            # manual: "M28": "The XY-axes move to the defined XY-position first and then to the machine
            # zero"; with XY it is "allowed in drilling and routing blocks".
            operations += self.end_contour(line)
            modal.contour = "left"
        return operations

    def track(self, line, motion, start, end, g, fields):
        modal = self.modal
        if 43 in g:
            raise Refusal(line, "G43 without G45, G46, G49 or G50")
        fields["compensation"] = modal.compensation
        if motion == 1:
            return self.operation("line", line, start=start, end=end, **fields)
        if modal.by_radius is None or (not modal.by_radius and None in (modal.i_mm, modal.j_mm)):
            raise Refusal(line, "an arc without R or I and J")
        clockwise = motion == 2
        if modal.by_radius:
            center = geometry.center_from_radius(start, end, modal.r_mm, clockwise, line)
        elif self.format == 1000:
            center = geometry.center_in_quadrant(start, end, modal.i_mm, modal.j_mm, clockwise, line)
        else:
            center = geometry.center_from_components(start, end, modal.i_mm, modal.j_mm, line)
        return self.operation("arc", line, start=start, end=end, center=center, clockwise=clockwise, **fields)

    def finished_contour(self, line, motion, center, g, fields):
        modal = self.modal
        if "round_mm" in fields or {40, 41, 42} & set(g) or (43 in g and motion in (47, 48)):
            raise Refusal(line, "a condition that a finished contour does not have")
        fields.update(center=center, clockwise=motion in (46, 48, 50), clear_area=43 in g)
        kind, size = "circle", None
        if motion in (49, 50):
            kind = "rectangle"
            size = (modal.r_mm, modal.r_mm) if modal.by_radius else (modal.i_mm, modal.j_mm)
            fields["size"] = size
        else:
            if not modal.by_radius:
                raise Refusal(line, "a circle without R")
            fields.update(radius=modal.r_mm, inside=motion in (45, 46))
        if None in (size or (modal.r_mm,)) or min(size or (modal.r_mm,)) <= 0:
            raise Refusal(line, "only positive sizes are allowed")
        if modal.tool in self.diameters:
            fields["plunge"] = geometry.plunge_point(motion, center, modal.r_mm, size, self.diameters[modal.tool])
        return self.operation(kind, line, **fields)
