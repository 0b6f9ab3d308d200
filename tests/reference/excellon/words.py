# SPDX-License-Identifier: Apache-2.0
"""Words of a block and the numbers in them."""
import re
from fractions import Fraction

from .model import Refused

MM_PER_INCH = Fraction(127, 5)
WORD = re.compile(r'([A-Z])([+-]?[0-9]*\.?[0-9]*)')
# Sections "Inch vs. Metric" and "Metric Measuring Mode": 00.0000; 000.000 (default), 0000.00, 000.00.
INCH_DIGITS = (2, 4)
METRIC_DIGITS = {'000.000': (3, 3), '0000.00': (4, 2), '000.00': (3, 2)}


def split_words(text, line):
    """[(letter, number text)] of one block; refuses what is no word."""
    words, end = [], 0
    for match in WORD.finditer(text):
        if match.start() != end:
            break
        words.append((match[1], match[2]))
        end = match.end()
    if end != len(text) or not words:
        raise Refused(line, f'no words: "{text[end:]}"')
    return words


def integer(text, line, what, digits):
    """An unsigned whole number of at most `digits` digits."""
    if not re.fullmatch(rf'[0-9]{{1,{digits}}}', text):
        raise Refused(line, f'{what}: "{text}" is no number of at most {digits} digits')
    return int(text)


class NumberFormat:
    """Unit, zeros and digits in force, and how they read a coordinate.

    Sections "Leading and Trailing Zeros", "Decimal Places". Zeros that no program states are those of
    the control's last job: only numbers that all settings read alike are accepted then.
    """

    def __init__(self):
        self.inch = None
        self.zeros = None
        self.metric_digits = METRIC_DIGITS['000.000']

    def digits(self):
        return INCH_DIGITS if self.inch else self.metric_digits

    def scale(self, line):
        """mm per unit."""
        if self.inch is None:
            raise Refused(line, 'a dimension before INCH, METRIC, M71 or M72')
        return MM_PER_INCH if self.inch else Fraction(1)

    def length_mm(self, text, line, leading_only=False):
        """A coordinate, distance or diameter in mm. An empty number is zero (the sample program's XY).

        leading_only  the word leaves out trailing zeros by its own rule (C), whatever INCH or METRIC state
        """
        scale = self.scale(line)
        sign = -1 if text.startswith('-') else 1
        digits = text.lstrip('+-')
        if not digits:
            if text:
                raise Refused(line, f'a sign without digits: "{text}"')
            return Fraction(0)
        if '.' in digits:
            if digits == '.':
                raise Refused(line, 'a decimal point without digits')
            return sign * scale * Fraction(digits if not digits.startswith('.') else '0' + digits)
        before, after = self.digits()
        if len(digits) > before + after:
            raise Refused(line, f'"{text}" has more than {before + after} digits')
        if len(digits) < before + after and int(digits):
            if self.zeros is None or (leading_only and self.zeros != 'LZ'):
                raise Refused(line, f'"{text}": leading or trailing zeros are not stated')
            digits = digits.ljust(before + after, '0') if self.zeros == 'LZ' else digits
        return sign * scale * Fraction(int(digits), 10 ** after)


def rate(text, line, what, reference_digits):
    """F and B: leading zeros kept, trailing zeros left out; F2 and F200 are 200, F02 and F020 are 20."""
    if not re.fullmatch(r'[0-9]{1,4}', text) or len(text) > reference_digits:
        raise Refused(line, f'{what}: "{text}" is no rate')
    return Fraction(int(text.ljust(reference_digits, '0')))


def spindle_speed_rpm(text, line):
    """S: thousands of rpm, trailing zeros not shown: S6 60000, S612 61200, S110.5 110500."""
    if re.fullmatch(r'[0-9]{1,3}\.[0-9]+', text):
        return Fraction(text) * 1000
    if re.fullmatch(r'[0-9]{1,5}', text):
        return Fraction(int(text.ljust(5, '0')))
    raise Refused(line, f'S: "{text}" is no spindle speed')
