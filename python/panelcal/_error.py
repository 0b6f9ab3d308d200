# SPDX-License-Identifier: Apache-2.0
"""The one exception of panelcal."""
from __future__ import annotations

from typing import Any


class Error(Exception):
    """A problem that panelcal states: its place, its kind, and the remedy.

    ``str(error)`` is the line that the command line prints::

        panel.exc:14:9: error[number-syntax]: ...; expected ...

    Attributes
    ----------
    code : str
        The slug of the diagnostic, as docs/diagnostics.md lists them.
    file : str
        The file, or the function whose arguments are wrong; may be empty.
    line, column : int
        From 1; 0 where there is none.
    what : str
        The offending text.
    expected : str
        The remedy; may be empty.
    log : list of dict
        All errors and warnings that were found, this one among them, each with
        severity, code, file, line, column, what, expected and text.
    """

    def __init__(self, text: str, code: str = "", file: str = "", line: int = 0, column: int = 0,
                 what: str = "", expected: str = "", log: list[dict[str, Any]] | None = None) -> None:
        super().__init__(text, code, file, line, column, what, expected, log)
        self.code = code
        self.file = file
        self.line = line
        self.column = column
        self.what = what
        self.expected = expected
        self.log = log or []

    def __str__(self) -> str:
        return str(self.args[0])
