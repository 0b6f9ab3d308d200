# SPDX-License-Identifier: Apache-2.0
"""A second reading of Excellon CNC-7 part programs, made from the manual alone.

`read_program` executes a program and returns its operations in machine order. The reading refuses
what the manual does not say: it never guesses, so that a difference from panelcal has one author.

Source  Excellon CNC-7 manual, Part Programming Commands; section names are cited where they decide.
"""
from .interpreter import Interpreter, Program, read_program
from .model import Operation, Placement, Refused, Tool

__all__ = ['Interpreter', 'Operation', 'Placement', 'Program', 'Refused', 'Tool', 'read_program']
