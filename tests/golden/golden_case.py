# SPDX-License-Identifier: Apache-2.0
"""Reads and writes one case file; README.md here defines the format.

Imports nothing but os: a test starts once for every case, and an import costs more than its work.
"""
import os

GOLDEN = os.path.dirname(os.path.abspath(__file__))
FIXTURES = os.path.join(GOLDEN, "fixtures")


class CaseError(Exception):
    """A case file, or a fixture that it names, breaks the format."""


class Case:
    """One run of panelcal: what it gets and what it must say and write."""

    def __init__(self, path):
        self.path = path
        self.comment = []  # lines without "# "
        self.command = None
        self.exit = None
        self.uses = []  # (fixture, name in the run folder or None)
        self.absent = []  # names
        self.same = {}  # expected file -> fixture with its content
        self.inputs = {}  # name -> bytes
        self.setup = b""
        self.err = b""
        self.out = b""
        self.files = {}  # expected file -> bytes


def fixture_files(fixture):
    """(path below fixtures/, name in the run folder) of each file of a fixture, file or folder."""
    path = os.path.join(FIXTURES, fixture)
    if os.path.isfile(path):
        return [(fixture, os.path.basename(fixture))]
    if not os.path.isdir(path):
        raise CaseError(f"fixtures/{fixture}: no such file or folder")
    return [(os.path.relpath(os.path.join(folder, name), FIXTURES),
             os.path.relpath(os.path.join(folder, name), path))
            for folder, _, names in sorted(os.walk(path)) for name in sorted(names)]


def fixture_bytes(fixture):
    try:
        with open(os.path.join(FIXTURES, fixture), "rb") as file:
            return file.read()
    except OSError as problem:
        raise CaseError(f"fixtures/{fixture}: {problem.strerror}") from problem


def all_inputs(case):
    """Name -> bytes of every input, those of fixtures included."""
    inputs = dict(case.inputs)
    for fixture, alias in case.uses:
        for path, name in fixture_files(fixture):
            name = alias or name
            if name in inputs:
                raise CaseError(f"{case.path}: two inputs are called {name}")
            inputs[name] = fixture_bytes(path)
    return inputs


def expected_files(case):
    """Name -> bytes of every file that the run must write."""
    return {**case.files, **{name: fixture_bytes(path) for name, path in case.same.items()}}


def is_marker(line):
    return line.startswith(b"--- ") and line.endswith(b" ---")


def unescape(data):
    r"""The bytes that an escaped section stands for: \\, \r, \xHH, and \ before a line's end."""
    first, *pieces = data.split(b"\\")
    found = [first]
    pieces.reverse()
    while pieces:
        piece = pieces.pop()
        if not piece:  # Two backslashes stand for one, and what follows is no escape.
            found.append(b"\\" + (pieces.pop() if pieces else b""))
        elif piece.startswith(b"\n"):
            found.append(piece[1:])
        elif piece.startswith(b"r"):
            found.append(b"\r" + piece[1:])
        elif piece.startswith(b"x"):
            found.append(bytes([int(piece[1:3], 16)]) + piece[3:])
        else:
            raise ValueError(f"unknown escape \\{chr(piece[0])}")
    return b"".join(found)


def is_plain(data):
    """Whether a section can hold these bytes as they are."""
    if data and not data.endswith(b"\n"):
        return False
    try:
        text = data.decode()
    except UnicodeDecodeError:
        return False
    if any(ord(c) < 32 and c not in "\t\n" or ord(c) == 127 for c in set(text)):
        return False
    return not any(is_marker(line) for line in data.split(b"\n"))


def escape_piece(data):
    found = []
    for byte in data:
        char = chr(byte)
        if char == "\\":
            found.append("\\\\")
        elif char == "\r":  # The line goes on in the file, but a reader sees where it ends.
            found.append("\\r\\\n")
        elif char in "\t\n" or 32 <= byte < 127:
            found.append(char)
        else:
            found.append(f"\\x{byte:02x}")
    return "".join(found)


def escape(data):
    text = "\\r\n".join(escape_piece(piece) for piece in data.split(b"\r\n"))
    text = "\n".join("\\x2d" + line[1:] if is_marker(line.encode()) else line
                     for line in text.split("\n"))
    return (text if text.endswith("\n") and data.endswith(b"\n") else text + "\\\n").encode()


def words_of(value):
    return [word.strip() for word in value.split(",")]


def read_header_line(case, line):
    key, colon, value = line.partition(": ")
    if line.startswith("#"):
        case.comment.append(line[2:])
    elif key == "command" and case.command is None:
        case.command = value
    elif key == "exit" and case.exit is None:
        case.exit = int(value)
    elif key == "use":
        for word in words_of(value):
            fixture, _, alias = word.partition(" as ")
            case.uses.append((fixture, alias or None))
    elif key == "absent":
        case.absent += words_of(value)
    elif key.startswith("file ") and value.startswith("same as "):
        case.same[key[len("file "):]] = value[len("same as "):]
    elif line:
        raise ValueError(f"no such line in a header, or it comes twice: {line!r}")


def add_section(case, title, data):
    words, comma, escaped = title.partition(", escaped")
    if escaped:
        raise ValueError(f"no such section: {title!r}")
    if comma:
        data = unescape(data)
    elif not is_plain(data):
        raise ValueError(f"section {title!r} holds bytes that have to be escaped")
    kind, _, name = words.partition(" ")
    if words in ("err", "out", "setup.py"):
        kind = words.removesuffix(".py")
        if getattr(case, kind):
            raise ValueError(f"section {title!r} comes twice")
        setattr(case, kind, data)
    elif kind in ("in", "file") and name:
        files = case.inputs if kind == "in" else case.files
        if name in files or kind == "file" and name in case.same:
            raise ValueError(f"section {title!r} comes twice")
        files[name] = data
    else:
        raise ValueError(f"no such section: {title!r}")


def parse(path, data):
    """The case that the bytes of a case file describe."""
    case = Case(path)
    title, body = None, []
    if not data.endswith(b"\n"):
        raise CaseError(f"{path}: the last line has no end")
    for number, line in enumerate(data[:-1].split(b"\n"), 1):
        try:
            if is_marker(line):
                if title is not None:
                    add_section(case, title, b"".join(body))
                title, body = line[4:-4].decode(), []
            elif title is None:
                read_header_line(case, line.decode())
            else:
                body += line, b"\n"
        except ValueError as problem:
            raise CaseError(f"{path}:{number}: {problem}") from problem
    try:
        if title is not None:
            add_section(case, title, b"".join(body))
    except ValueError as problem:
        raise CaseError(f"{path}: {problem}") from problem
    if not case.comment:
        raise CaseError(f"{path}: no comment says what the case pins")
    if not case.command or case.exit is None:
        raise CaseError(f"{path}: command or exit is missing")
    return case


def load(path):
    with open(path, "rb") as file:
        return parse(path, file.read())


def section(title, data):
    if is_plain(data):
        return b"--- %s ---\n%s" % (title.encode(), data)
    return b"--- %s, escaped ---\n%s" % (title.encode(), escape(data))


def text_of(case):
    """The case file, in the one form that a case has: parse and text_of are inverse."""
    head = [f"# {line}".rstrip() for line in case.comment]
    head += [f"command: {case.command}", f"exit: {case.exit}"]
    if case.uses:
        head.append("use: " + ", ".join(f"{fixture} as {alias}" if alias else fixture
                                        for fixture, alias in case.uses))
    if case.absent:
        head.append("absent: " + ", ".join(case.absent))
    head += [f"file {name}: same as {fixture}" for name, fixture in sorted(case.same.items())]
    sections = [section(f"in {name}", data) for name, data in case.inputs.items()]
    sections += [section(title, data) for title, data in
                 (("setup.py", case.setup), ("err", case.err), ("out", case.out)) if data]
    sections += [section(f"file {name}", data) for name, data in sorted(case.files.items())]
    blank = [b"\n"] if sections else []
    return b"".join([("\n".join(head) + "\n").encode(), *blank, *sections])
