# SPDX-License-Identifier: Apache-2.0
"""Prints the operations of a program, one JSON object a line: python3 -m sieb_meyer PROGRAM [SUBPROGRAMS]"""

import dataclasses
import json
import pathlib
import sys

from . import Refusal, interpret


def main():
    texts = [pathlib.Path(name).read_bytes().decode("latin-1") for name in sys.argv[1:]]
    if len(texts) not in (1, 2):
        sys.exit(__doc__)
    try:
        operations = interpret(*texts)
    except Refusal as refusal:
        sys.exit(f"{sys.argv[1]}:{refusal}")
    for operation in operations:
        print(json.dumps({key: value for key, value in dataclasses.asdict(operation).items() if value is not None}))


main()
