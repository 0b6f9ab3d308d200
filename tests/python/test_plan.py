# SPDX-License-Identifier: Apache-2.0
import json

import pytest

import panelcal
from conftest import CLOCK, run_panelcal


def test_facts_are_those_of_the_command_line_to_the_bit(demo, machine, tmp_path):
    run_panelcal("plan", demo / "panel.exc", "-m", demo / "machine.toml", "--clock", CLOCK,
                 "--json", tmp_path / "plan.json")
    expected = json.loads((tmp_path / "plan.json").read_text())
    program = panelcal.read_program(demo / "panel.exc", machine)
    for source in (program, demo / "panel.exc"):
        facts = panelcal.plan(source, machine, clock=CLOCK)
        for one in (facts, dict(expected)):
            one.pop("provenance")
        assert facts == {key: expected[key] for key in facts}


def test_arguments_are_checked(demo, machine):
    with pytest.raises(panelcal.Error) as error:
        panelcal.plan(demo / "panel.exc", machine, n_added=0)
    assert (error.value.code, error.value.file) == ("usage", "panelcal.plan")
