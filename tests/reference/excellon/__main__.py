# SPDX-License-Identifier: Apache-2.0
"""Prints the operations of a program as JSON lines: python3 -m excellon program.drl"""
import json
import sys

from . import Refused, read_program


def main():
    try:
        with open(sys.argv[1], encoding='ascii') as file:
            program = read_program(file.read())
    except Refused as refusal:
        print(f'{sys.argv[1]}: {refusal}', file=sys.stderr)
        return 2
    for operation in program.operations:
        print(json.dumps(operation.as_json()))
    return 0


if __name__ == '__main__':
    sys.exit(main())
