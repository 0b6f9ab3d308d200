# SPDX-License-Identifier: Apache-2.0
"""Program text -> lines of words: formats, comments, numbers, the table of tools, subprogram files."""

import dataclasses
import re
from typing import Optional

from .numbers import Format, Unread


class Refusal(Exception):
    """The program says something that the manual does not settle, or forbids."""

    def __init__(self, line, message):
        super().__init__(f"{line}: {message}")
        self.line = line
        self.message = message


@dataclasses.dataclass(frozen=True)
class Word:
    letter: str
    digits: str  # as written; "" where only the letter is programmed


@dataclasses.dataclass
class Block:
    """One program line."""

    line: int
    words: list
    command: str = ""  # "M47" ... : a command with text, at the end of the line
    text: str = ""
    labeled: bool = False  # begins with "/"
    zero: Optional[tuple] = None  # of an offset line in a subprogram: zero point of the call, mm


@dataclasses.dataclass
class Program:
    format: Format  # 1000, 3000, 5000
    blocks: list
    diameters_mm: dict  # tool -> D of the table of tools
    z_offsets_mm: dict  # tool -> Z of the table of tools


TEXT_COMMAND = re.compile(r"(M47|M49|M75|M76|M97|M98|M99|G35|G39)")
WORD = re.compile(r"([A-Z]) *(-?[0-9]*\.?[0-9]*)")

# manual: appendix B, "SIEB & MEYER Formats", and the table at the head of each command.
LETTERS = {1000: "FGIJMTVWXY", 3000: "DFGHIJKMRTVWXYZ", 5000: "DEFGHIJKLMPRTVWXYZ"}
G_CODES = {1000: {1, 2, 3, 11, 41, 42, 45, 46, 49, 50, 90, 91}}
G_CODES[3000] = G_CODES[1000] | {40, 47, 48, 82, 83, 84, 85}
G_CODES[5000] = G_CODES[3000] | {6, 30, 31, 32, 33, 34, 36, 43, 80, 81, 88, 89} | set(range(70, 80))
M_CODES = {1000: {20, 21, 30, 50, 60, 70, 80, 90}}
M_CODES[3000] = M_CODES[1000] | {28, 29, 31}
M_CODES[5000] = (M_CODES[3000] | set(range(22, 28)) | set(range(34, 46)) | set(range(52, 59)) | {92, 93, 94, 95})
V_CODES = {1000: {1, 2}, 3000: {1, 2}, 5000: {1, 2, 3, 4}}
TEXTS = {1000: set(), 3000: {"M47", "M97", "M98"}}
TEXTS[5000] = TEXTS[3000] | {"M49", "M75", "M76", "M99", "G35", "G39"}


def value(word, line, format_):
    """The number of a word, in mm; F in m/min."""
    try:
        return format_.value(word.letter, word.digits)
    except Unread as problem:
        raise Refusal(line, str(problem)) from None


def count(word, line):
    """The number of a word that counts or names."""
    if not re.fullmatch("[0-9]+", word.digits):
        raise Refusal(line, f'no whole number: "{word.letter}{word.digits}"')
    return int(word.digits)


def check_word(word, line, format_):
    if word.letter not in LETTERS[format_]:
        raise Refusal(line, f"{word.letter} is no command of Format {format_}")
    for letter, codes in (("G", G_CODES), ("M", M_CODES), ("V", V_CODES)):
        if word.letter == letter and count(word, line) not in codes[format_]:
            raise Refusal(line, f"{letter}{word.digits} is no command of Format {format_}")


def read_block(text, line, format_):
    """One line -> Block, or None for a line without words."""
    block = Block(line, [])
    rest = text.strip()
    if rest.startswith("/"):
        # manual: "/: Label Program Line"
        if format_ == 1000:
            raise Refusal(line, "/ is no command of Format 1000")
        block.labeled = True
        rest = rest[1:].lstrip()
    while rest:
        if rest[0] == "(":
            # manual: "(: Comment": alone in a line or at the end of a program line; not in Format 1000.
            comment = re.match(r"\([^)]*\)?\s*$", rest)
            if comment is None or format_ == 1000:
                raise Refusal(line, "a comment must stand at the end of a program line")
            break
        command = TEXT_COMMAND.match(rest)
        if command:
            if command[0] not in TEXTS[format_]:
                raise Refusal(line, f"{command[0]} is no command of Format {format_}")
            text = rest[len(command[0]):]
            if not text.startswith(",") and command[0] != "M47":
                raise Refusal(line, f'{command[0]} and its text must be separated by a comma: "{rest}"')
            block.command, block.text = command[0], text.removeprefix(",").strip()
            break
        word = WORD.match(rest)
        if word is None:
            raise Refusal(line, f'no command: "{rest}"')
        block.words.append(Word(word[1], word[2]))
        check_word(block.words[-1], line, format_)
        rest = rest[word.end():].lstrip()
    return block if block.words or block.command else None


def split_lines(text):
    """manual: A.4 End of Line: LF, CR, LF CR or CR LF."""
    return re.split("\r\n|\n\r|\n|\r", text)


def read(text, setting=None):
    """A program file -> Program. manual: A.5 to A.7."""
    lines = split_lines(text)
    header = next((i for i, line in enumerate(lines) if line.startswith("%%")), None)
    if header is None:
        raise Refusal(1, 'no "%%": the beginning of the program is missing')
    try:
        format_ = Format.of(lines[header].rstrip(), setting)
    except Unread as problem:
        raise Refusal(header + 1, str(problem)) from None
    blocks = []
    end = len(lines)
    for i in range(header + 1, len(lines)):
        if lines[i].startswith("$"):
            end = i
            break
        block = read_block(lines[i], i + 1, format_)
        if block is not None:
            blocks.append(block)
    diameters, offsets = read_tools(lines[end:], end + 1, format_)
    return Program(format_, blocks, diameters, offsets)


def read_tools(lines, first_line, format_):
    """The table of tools behind "$" -> diameters and Z offsets by tool. manual: "Tool Parameters"."""
    diameters, offsets = {}, {}
    if not lines:
        return diameters, offsets
    if format_ == 1000:
        values = "".join(lines).strip().split("$")[1:]
        for tool, i in enumerate(range(0, min(len(values), 90), 6), start=1):
            rates = [Word("TF", values[i + 2].strip()), Word("TR", values[i + 3].strip())] if i + 3 < len(values) else []
            for word in rates:
                value(word, first_line, format_)
            if values[i].strip():
                diameters[tool] = value(Word("TD", values[i].strip()), first_line, format_)
        return diameters, offsets
    tool = None
    for number, line in enumerate(lines, start=first_line):
        line = line.strip()
        if line == "$" and number > first_line:
            break
        for word in re.finditer(r"([A-Z])(-?[0-9]*\.?[0-9]*)|(\S)", line.removeprefix("$")):
            if word[3]:
                raise Refusal(number, f'no tool parameter: "{word[3]}"')
            if word[1] not in "TDSFRNAZM":
                raise Refusal(number, f'no tool parameter: "{word[0]}"')
            if word[1] == "T":
                tool = int(word[2])
            elif tool is None:
                raise Refusal(number, "a tool parameter stands before the number of its tool")
            elif word[1] == "D":
                diameters[tool] = value(Word("TD", word[2]), number, format_)
            elif word[1] == "Z":
                offsets[tool] = value(Word("TZ", word[2]), number, format_)
            elif word[1] in "FR":
                value(Word("T" + word[1], word[2]), number, format_)
    return diameters, offsets


def read_subprograms(text):
    """A subprogram file -> blocks by name. manual: chapter 6, "@: Define Subprogram"."""
    subprograms = {}
    name = None
    for number, line in enumerate(split_lines(text), start=1):
        if line.startswith("@"):
            name = line[1:].strip()
            if name in subprograms or not re.fullmatch("[A-Z0-9-]+", name):
                raise Refusal(number, f'no name of a subprogram, or a second one: "{line}"')
            subprograms[name] = []
            continue
        block = read_block(line, number, 5000)
        if block is None:
            continue
        if name is None:
            raise Refusal(number, "a subprogram file must begin with @ and a name")
        subprograms[name].append(block)
    return subprograms


def last(block, letter) -> Optional[Word]:
    """The word with this letter; the last one counts (manual: A.3)."""
    found = None
    for word in block.words:
        if word.letter == letter:
            found = word
    return found


def codes(block, letter):
    """The numbers of all words with this letter, in the order of the line."""
    return [count(word, block.line) for word in block.words if word.letter == letter]
