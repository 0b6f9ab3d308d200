# SPDX-License-Identifier: Apache-2.0
import json

import pytest

import panelcal
from conftest import CLOCK, run_panelcal

PANEL = ("M48\nMETRIC,LZ\nT1C0.800\n%\nG90\nG34,1\nG36X6.000Y6.000\nG36X224.000Y6.000\n"
         "G36X6.000Y269.000\nT1\nX20.000Y20.000\nX100.000Y150.000\nX210.000Y260.000\nM30\n")


def test_facts_are_those_of_the_command_line_to_the_bit(demo, machine, tmp_path):
    file = tmp_path / "panel.exc"
    file.write_text(PANEL)
    run_panelcal("plan", file, "-m", demo / "machine.toml", "--clock", CLOCK, "--add", 2, "--json",
                 tmp_path / "plan.json")
    expected = json.loads((tmp_path / "plan.json").read_text())
    del expected["provenance"]
    program = panelcal.read_program(file, machine)
    for source in (program, file, PANEL):
        facts = panelcal.plan(source, machine, n_added=2, clock=CLOCK)
        del facts["provenance"]
        if source is PANEL:
            facts["program"] = str(file)  # a text has no file
        assert facts == expected
    assert expected["series"][0]["targets"]


def test_arguments_are_checked(demo, machine):
    with pytest.raises(panelcal.Error) as error:
        panelcal.plan(PANEL, machine, n_added=0)
    assert (error.value.code, error.value.file) == ("usage", "panelcal.plan")
    with pytest.raises(panelcal.Error) as error:
        panelcal.plan(PANEL.replace("X20.000", "X20.0?0"), machine)
    assert (error.value.file, error.value.line) == ("program", 11)
