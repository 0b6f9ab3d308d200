# SPDX-License-Identifier: Apache-2.0
import json

import numpy as np
import pytest

import panelcal
from conftest import run_panelcal

EXCELLON = "M48\nMETRIC,LZ\nT1C0.8\nT2C1.2\n%\nT1\nX010Y020\nX030Y020\nT2\nX010Y020G85X010Y025\nM30\n"


def test_holes_and_operations_are_columns():
    program = panelcal.read_program(EXCELLON)
    assert (program.file, program.dialect.startswith("Excellon")) == ("program", True)
    assert program.tools[2] == {"diameter_mm": 1.2}
    first = program.operations[program.operations.tool == 1].holes
    assert first.nominal_mm.tolist() == [[10, 20], [30, 20]]
    assert first.line.tolist() == [7, 8] and first.diameter_mm.tolist() == [0.8, 0.8]
    assert np.isnan(first.risk).all() and not first.cov_mm2.any()
    assert {"tool", "drill", "stop"} <= set(program.operations.op)
    stops = program.operations[program.operations.op == "stop"]
    assert stops.line.tolist() == [5, 11] and np.isnan(stops.nominal_mm).all()


def test_a_slot_has_a_row_for_each_end(demo):
    machine = panelcal.read_machine(demo / "machine.toml")
    job = panelcal.correct(EXCELLON, machine, uncorrected=True, format="excellon")
    rows = job.operations[np.char.startswith(job.operations.op, "slot")]
    assert rows.op.tolist() == ["slot", "slot_end"]
    assert rows.nominal_mm.tolist() == [[10, 20], [10, 25]]
    assert b"G85" in job.program


def test_requests_are_those_of_survey(demo, machine):
    program = panelcal.read_program(demo / "panel.exc", machine)
    lines = run_panelcal("survey", demo / "panel.exc", "-m", demo / "machine.toml").splitlines()
    assert program.requests == [json.loads(line) for line in lines]
    assert len(program.holes) == 990


def test_an_error_has_its_place(tmp_path):
    with pytest.raises(panelcal.Error) as error:
        panelcal.read_program(EXCELLON.replace("X030Y020", "X03?Y020"), name="panel.exc")
    assert (error.value.file, error.value.line) == ("panel.exc", 8)
    assert str(error.value).startswith("panel.exc:8:") and error.value.code in str(error.value)
    with pytest.raises(panelcal.Error) as error:
        panelcal.read_program(tmp_path / "missing.exc")
    assert error.value.code == "file-unreadable"


def test_a_machine_that_is_wrong_names_the_nearest_key(machine, demo):
    with pytest.raises(panelcal.Error) as error:
        panelcal.parse_machine('[machine]\nnam = "x"\n', "m.toml")
    assert (error.value.code, error.value.line) == ("config-key-unknown", 2)
    assert "name" in error.value.expected
    assert machine.name == "demo driller" and machine.picture_px == (480, 480)
    assert machine.targets[1].size_mm == 2 and machine.mapping.scale_mm_per_px > 0
