# SPDX-License-Identifier: Apache-2.0
import json
import shutil

import numpy as np
import pytest

import panelcal
from conftest import CLOCK, run_panelcal


@pytest.fixture(scope="module")
def by_program(demo, tmp_path_factory):
    """The demo's job as the command line does it: facts, operations, measurements."""
    folder = tmp_path_factory.mktemp("program")
    run_panelcal("run", demo / "panel.exc", "-m", demo / "machine.toml", "--images", demo / "images",
                 "--clock", CLOCK, "-o", folder / "out.jsonl", "--json", folder / "facts.json",
                 "--save-measurements", folder / "seen.jsonl")
    (folder / "out.jsonl").rename(folder / "by_program.jsonl")
    return folder


@pytest.fixture(scope="module")
def job(demo, machine, by_program):
    return panelcal.correct(demo / "panel.exc", machine, images=demo / "images", clock=CLOCK,
                            output=by_program / "out.jsonl")


def comparable(facts):
    return {key: value for key, value in facts.items() if key != "provenance"}


def test_facts_are_those_of_the_command_line_to_the_bit(job, by_program):
    facts = json.loads((by_program / "facts.json").read_text())
    assert comparable(job.facts) == comparable(facts)
    assert job.verdict == facts["verdict"]["word"] == "drill" and job.may_be_drilled


def test_the_output_is_the_same_byte_for_byte(job, by_program):
    assert job.is_written and job.program is None
    assert (by_program / "out.jsonl").read_bytes() == (by_program / "by_program.jsonl").read_bytes()


def test_columns_are_the_operations_of_the_output(job, by_program):
    rows = [json.loads(line) for line in (by_program / "by_program.jsonl").read_text().splitlines()]
    assert job.operations.op.tolist() == [row["op"] for row in rows]
    assert job.operations.line.tolist() == [row["line"] for row in rows]
    drills = [row for row in rows if row["op"] == "drill"]
    holes = job.holes
    half_a_digit = 0.5e-6 * (1 + 1e-6)  # the output has nanometres
    for key, column in (("nominal", holes.nominal_mm), ("actual", holes.actual_mm),
                        ("sigma", holes.sigma_mm)):
        assert np.abs(column - [row[key] for row in drills]).max() <= half_a_digit, key
    assert holes.tool.tolist() == [row["tool"] for row in drills]
    assert [list(holes.boards[i]) for i in holes.board] == [row.get("path", []) for row in drills]


def test_its_measurements_give_the_same_job_again(job, demo, machine, by_program):
    lines = (by_program / "seen.jsonl").read_text().splitlines()
    assert job.measurements == [json.loads(line) for line in lines]
    for measurements in (job.measurements, by_program / "seen.jsonl"):
        again = panelcal.correct(demo / "panel.exc", machine, measurements, facts=False)
        assert np.array_equal(again.holes.actual_mm, job.holes.actual_mm)
        assert np.array_equal(again.holes.cov_mm2, job.holes.cov_mm2)
        assert again.facts is None and again.verdict == "drill"
    facts = panelcal.correct(demo / "panel.exc", machine, job.measurements).facts
    assert (facts["output"], facts["verdict"]["word"]) == ("-", "drill")


def test_a_program_in_another_language_is_the_command_lines(demo, machine, job, by_program):
    run_panelcal("run", demo / "panel.exc", "-m", demo / "machine.toml", "--measurements",
                 by_program / "seen.jsonl", "-o", by_program / "out.drl")
    again = panelcal.correct(demo / "panel.exc", machine, by_program / "seen.jsonl",
                             format="excellon")

    def blocks(text):
        return [line for line in text.splitlines() if not line.startswith(b";")]

    assert blocks(again.program) == blocks((by_program / "out.drl").read_bytes())


def test_a_job_outside_of_its_limits_is_held_and_gives_no_places(demo, machine, job, tmp_path):
    moved = [dict(row) for row in job.measurements]
    far_mm = 0.2
    moved[0]["measured"] = [moved[0]["measured"][0] + far_mm, moved[0]["measured"][1]]
    held = panelcal.correct(demo / "panel.exc", machine, moved, output=tmp_path / "out.drl")
    assert (held.may_be_drilled, held.verdict, held.operations) == (False, "hold", None)
    assert not (tmp_path / "out.drl").exists()
    assert any(row["severity"] == "error" for row in held.diagnostics)
    forced = panelcal.correct(demo / "panel.exc", machine, moved, force=True,
                              output=tmp_path / "out.drl")
    assert forced.verdict == "forced" and (tmp_path / "out.drl").exists()


def test_no_output_replaces_what_the_job_reads(demo, job, tmp_path):
    for name in ("panel.exc", "machine.toml", "camera.cal.json"):
        shutil.copy(demo / name, tmp_path)
    lines = "".join(json.dumps(row) + "\n" for row in job.measurements)
    (tmp_path / "seen.jsonl").write_text(lines)
    (tmp_path / "truth.json").write_bytes((demo / "images/truth.json").read_bytes())
    (tmp_path / "link.drl").symlink_to("panel.exc")
    kept = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for name in (*kept, "../" + tmp_path.name + "/seen.jsonl"):
        with pytest.raises(panelcal.Error) as error:
            panelcal.correct(tmp_path / "panel.exc", tmp_path / "machine.toml",
                             tmp_path / "seen.jsonl", truth=tmp_path / "truth.json",
                             output=tmp_path / name, format="excellon")
        assert (error.value.code, error.value.file) == ("output-in-use", "panelcal.correct"), name
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == kept
    with pytest.raises(panelcal.Error) as error:
        panelcal.correct(demo / "panel.exc", demo / "machine.toml", images=demo / "images",
                         output=demo / "images/new.drl")
    assert error.value.code == "output-in-use"
    assert panelcal.correct(tmp_path / "panel.exc", tmp_path / "machine.toml",
                            tmp_path / "seen.jsonl", output=tmp_path / "new.drl").is_written


def test_what_keeps_a_job_from_being_measured_is_raised(demo, machine, job):
    with pytest.raises(panelcal.Error) as error:
        panelcal.correct(demo / "panel.exc", machine, job.measurements[:-1])
    assert error.value.code == "measurement-missing"
    with pytest.raises(panelcal.Error) as error:
        panelcal.correct(demo / "panel.exc", machine)
    assert (error.value.code, error.value.file) == ("usage", "panelcal.correct")
    with pytest.raises(panelcal.Error) as error:
        panelcal.correct("M48\nMETRIC,LZ\nT1C0.8\n%\nT1\nX01Q\nM30\n", machine, uncorrected=True)
    assert (error.value.file, error.value.line) == ("program", 6)
    assert error.value.log[0]["text"] == str(error.value)


def test_the_virtual_machine_is_a_source(demo, machine):
    sim = panelcal.correct(demo / "panel.exc", machine, driver="sim", facts=False, n_threads=2)
    assert sim.may_be_drilled and len(sim.measurements) == 21
