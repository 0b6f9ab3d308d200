# SPDX-License-Identifier: Apache-2.0
"""The number format of a program: "metric or inch, resolution, leading or trailing zeros" (manual: A.1).

The manual has the units of the formats 1000, 3000 and 5000 in millimetres (appendix B, and the table at the head of
each command). "Other units are special cases and not considered in this manual (Formats xx01 to xx10)": a setting of
the control (CNC command FP), or the operator, states them. What then still has two readings is refused.
"""

import dataclasses
import re
from fractions import Fraction
from typing import Optional

INCH_MM = Fraction(254, 10)

# Decimals of a number without a point, mm (F: m/min). The table of tools has T- before its letters.
DECIMALS = {
    1000: {**dict.fromkeys("XYIJ", 2), "F": 1, "TD": 2, "TF": 1, "TR": 1},
    3000: {**dict.fromkeys("XYIJRD", 3), **dict.fromkeys("HKZ", 2), "F": 1, "TD": 2, "TF": 1, "TR": 1},
    5000: {**dict.fromkeys("XYIJRDHKZ", 3), "F": 3, "TD": 2, "TZ": 3, "TF": 1, "TR": 1},
}
RATES = {"F", "TF", "TR"}


class Unread(Exception):
    """A number that is malformed, or that has no reading or two."""


@dataclasses.dataclass(frozen=True)
class Setting:
    """What the control or the operator states; None: nothing."""

    units: Optional[str] = None  # "inch", "metric"
    zeros: Optional[str] = None  # "LZ" (leading ones are kept), "TZ"
    digits: Optional[tuple] = None  # before and behind the point
    rates: Optional[str] = None  # of F and R in inch: "inch/min", "m/min"
    rules: bool = False  # the operator's word: over the digits behind %%


class Format(int):
    """1000, 3000 or 5000: the commands; with the reading of its numbers."""

    inch = False
    leading = False
    decimals = 3  # of coordinates
    whole = None  # digits before the point, where leading zeros are kept
    rates = None

    @classmethod
    def of(cls, mark, setting):
        """The format behind "%%". Raises Unread if there is none, or if something is left open."""
        digits = mark.removeprefix("%%")
        known = re.fullmatch("([135]0)(0[0-9]|10)", digits) if digits else re.fullmatch("(.?)(.?)", "")
        if known is None:
            raise Unread(f'no format of this manual: "{mark}"')
        special = digits != "" and known[2] != "00"
        format_ = cls(int(known[1]) * 100 if digits else 1000)
        format_.decimals = DECIMALS[format_]["X"]
        # manual: A.6.1: "When the program is loaded another format than the default format is used": the digits
        # state all; without them the default format holds.
        if setting is None or (digits and not special and not setting.rules):
            if special:
                raise Unread(f'nothing states the numbers of "{mark}"')
            return format_
        if special and None in (setting.units, setting.zeros, setting.digits):
            raise Unread(f'the numbers of "{mark}" need units, zeros and digits')
        if not digits and not setting.rules and None in (setting.units, setting.zeros, setting.digits):
            # A part may be there for programs in the other language: the manual's format, unless the control is in inch.
            if setting.units == "inch":
                raise Unread(f'"{mark}" is in millimetres or in inch')
            return format_
        format_.inch = setting.units == "inch"
        format_.leading = setting.zeros == "LZ"
        format_.rates = setting.rates
        if setting.digits:
            format_.whole, format_.decimals = setting.digits
        elif format_.leading or (format_.inch and format_ == 1000):
            raise Unread(f'"{mark}" needs digits')
        elif format_.inch:
            format_.decimals = 4  # manual: M58: "minimum = 0.001 mm, minimum = 0.0001 inch"
        return format_

    def has_point(self, name):
        # manual: B: no decimal points in Format 1000, "No decimal point allowed!" for F in Format 3000; the table of
        # tools of Format 3000 has whole numbers.
        return self == 5000 or (self == 3000 and name != "F" and not name.startswith("T"))

    def value(self, name, digits):
        """mm; F and R in m/min. A letter alone is zero (manual: example FINAL, "XY500.")."""
        decimals = DECIMALS[self].get(name)
        if decimals is None:
            raise Unread(f"{name} has no unit in Format {int(self)}")
        if digits == "":
            return 0.0
        if not re.search("[0-9]", digits):
            raise Unread(f'no number: "{name}{digits}"')
        point = "." in digits
        if point and not self.has_point(name):
            raise Unread(f'decimal point in Format {int(self)}: "{name}{digits}"')
        if not re.search("[1-9]", digits):
            return 0.0
        unit = self.unit(name, digits, point)
        if point:
            return float(Fraction(digits) * unit)
        return float(int(digits) * unit / 10 ** self.decimals_of(name, digits, decimals))

    def unit(self, name, digits, point):
        if not self.inch:
            return 1
        if name not in RATES:
            return INCH_MM
        if self.rates is None or (self.rates == "inch/min" and not point):
            raise Unread(f'no unit of a rate in inch: "{name}{digits}"')
        return INCH_MM / 1000 if self.rates == "inch/min" else 1

    def decimals_of(self, name, digits, decimals):
        if name in RATES:
            return decimals
        usual = DECIMALS[self]["X"]
        n_digits = len(digits.lstrip("+-"))
        if self.inch or self.decimals != usual:
            if decimals != usual:
                raise Unread(f'no step is stated: "{name}{digits}"')
            decimals = self.decimals
        if not self.leading:
            return decimals
        if name in "XY":
            if n_digits > self.whole + self.decimals:
                raise Unread(f'too many digits: "{name}{digits}"')
            return n_digits - self.whole
        if n_digits != self.whole + decimals:
            raise Unread(f'zeros are left off: "{name}{digits}"')
        return decimals
