#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The figures of a quality certificate, derived again from the ledger's own records.

    certificate_test.py PANELCAL REPOSITORY

The formulas are those of the GUM (JCGM 100:2008) and of AIAG's Measurement Systems Analysis; quantiles come
from densities, summed here.
"""
import hashlib
import json
import math
import os
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(sys.argv.pop()).resolve()
PANELCAL = str(Path(sys.argv.pop()).resolve())
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tests/golden"), str(ROOT / "tests/support")]
import golden_ledger  # noqa: E402
import golden_table  # noqa: E402
from facts import checked, in_page  # noqa: E402

SUBJECT = "spindle 1 station 1"
LOOKS, HOLES = "looks at a hole", "holes about the fit"
MACHINE = '[machine]\nname = "drill 1"\n'
PLATE = """[plate]
name = "B 17"
columns = 9
rows = 9
pitch_mm = 25
certified = true
certificate = "123 of 2026"
expanded_uncertainty_um = 0.6
coverage_factor = 2
"""
COVERAGE = 0.9545


def quantile(density, share, low, high, n=20000):
    """Where the density's integral, by Simpson's rule, has this share of its whole."""
    h = (high - low) / n
    sums = [0.0]
    for i in range(n):
        a = low + i * h
        sums.append(sums[-1] + h / 6 * (density(a) + 4 * density(a + h / 2) + density(a + h)))
    wanted = share * sums[-1]
    i = next(i for i, one in enumerate(sums) if one >= wanted)
    return low + h * (i - 1 + (wanted - sums[i - 1]) / (sums[i] - sums[i - 1]))


def coverage_factor(degrees):
    """Student's t; its density beyond 50 is nothing for the degrees of these tests."""
    return quantile(lambda t: (1 + t * t / degrees) ** (-(degrees + 1) / 2), (1 + COVERAGE) / 2, -50, 50)


def chi_square(degrees, share):
    top = degrees + 15 * math.sqrt(2 * degrees) + 30
    mode = degrees - 2
    return quantile(lambda x: math.exp((degrees / 2 - 1) * math.log((x + 1e-300) / mode) - (x - mode) / 2), share, 0, top)


def night(i, x, y, verdict="installed", looks=(1.1e-6, 52), holes=(9e-6, 16), backlash=(0.4, -0.2), **more):
    """A night's entry and the one beside it."""
    entry, _ = golden_ledger.offset(x, y, f"2026-11-{i:02}T02:00:00Z", verdict=verdict, **more)
    result = json.dumps({
        "kind": "spindle-camera", "version": 1, "date": entry["time"], "provenance": "made up", "units": {"length": "mm"},
        "offsets": [{"spindle": 1, "station": 1, "date": entry["time"], "offset_mm": [x, y], "covariance_mm2": entry["covariance"],
                     "quality": {"holes": 9, "looks": 36, "left_out": 0, "wander_um": [3, 3], "repeatability_um": [1 + 0.1 * i, 0.9],
                                 "backlash_um": list(backlash)}}]})
    rows = [("variance: " + HOLES, holes[0], "mm^2"), ("degrees of freedom: " + HOLES, holes[1], "1"),
            ("variance: " + LOOKS, looks[0], "mm^2"), ("degrees of freedom: " + LOOKS, looks[1], "1")]
    beside = {**entry, "kind": "self-test", "subject": "spindle-camera " + entry["subject"], "verdict": "measured", "reason": "",
              "inputs": [], "covariance": None, "replaces": None,
              "parameters": [{"name": name, "value": value, "unit": unit} for name, value, unit in rows]}
    return [(entry, result), (beside, json.dumps({"kind": "night-step", "version": 1}))]


def nights():
    """Seven of which one was refused and looked worse."""
    chance = random.Random(20261128)
    out = []
    for i in range(1, 8):
        verdict = "refused" if i == 5 else "installed"
        x, y = (50 + chance.gauss(0, 0.004), -3 + chance.gauss(0, 0.003)) if i != 5 else (50.3, -2.5)
        out += night(i, x, y, verdict, looks=((0.9 + 0.05 * i) * 1e-6, 50 + i) if i != 5 else (1e-3, 9),
                     holes=((8 + 0.2 * i) * 1e-6, 16), backlash=(0.4 + 0.1 * (-1) ** i, -0.2))
    return out


def table_error(x, y):
    return 1e-4 * x, 0.04 * (x / 200) ** 2 - 1e-4 * y


def table_entry(plate=PLATE):
    entry, _ = golden_ledger.offset(0, 0, "2026-11-08T02:00:00Z", subject="table", kind="table", parameters=[
        {"name": name, "value": 1e-5 * (i + 1), "unit": "1" if "scale" in name else "rad" if "square" in name else "mm"}
        for i, name in enumerate(golden_table.GEOMETRY)],
        covariance=[[1e-12 * (i + 1) ** 2 if i == j else 0 for j in range(11)] for i in range(11)],
        inputs=[{"name": "plate.toml", "sha256": hashlib.sha256(plate.encode()).hexdigest(), "bytes": len(plate)}])
    return entry, golden_table.table(table_error)


def run(*words, code=0):
    done = subprocess.run([PANELCAL, "history", "certificate", "-l", "drill1.ledger", "-m", "machine.toml", *words],
                          capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done


def certificate(*words):
    return checked(json.loads(run(*words, "--json", "-").stdout), ROOT)


def records():
    rows = sqlite3.connect("file:drill1.ledger?mode=ro", uri=True).execute("SELECT content, result FROM ledger_entry ORDER BY id")
    return [(json.loads(content), json.loads(result)) for content, result in rows]


def counted():
    """The installed offsets, each with the entry beside it."""
    all_of_it = records()
    return [(entry, beside, result) for (entry, result), (beside, _) in zip(all_of_it, all_of_it[1:])
            if entry["kind"] == "spindle-camera" and entry["verdict"] == "installed"]


def parameter(entry, name):
    return next(one["value"] for one in entry["parameters"] if one["name"] == name)


def pooled(name):
    """Variance in um^2 and degrees of freedom."""
    rows = [(parameter(beside, "variance: " + name), parameter(beside, "degrees of freedom: " + name)) for _, beside, _ in counted()]
    degrees = sum(one for _, one in rows)
    return 1e6 * sum(variance * one for variance, one in rows) / degrees, degrees


class Certificates(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.addCleanup(os.chdir, "/")
        os.chdir(self.folder.name)
        Path("machine.toml").write_text(MACHINE + "[tolerance]\nposition_um = 40\n", encoding="ascii")
        Path("plate.toml").write_text(PLATE, encoding="ascii")

    def near(self, found, wanted, relative=1e-9):
        self.assertLessEqual(abs(found - wanted), relative * abs(wanted), (found, wanted))

    def what_is_lacking(self, document):
        return {one["what"]: one["why"] for one in document["not_measured"]}

    def check_scatter(self, row, variance, degrees):
        self.near(row["sigma"], math.sqrt(variance))
        self.near(row["degrees_of_freedom"], degrees)
        self.near(row["low"], math.sqrt(variance * degrees / chi_square(degrees, 0.975)), 1e-5)
        self.near(row["high"], math.sqrt(variance * degrees / chi_square(degrees, 0.025)), 1e-5)

    def check_spindle(self, document, tolerance_um):
        """Gauge study and budget against the records; gives what of the budget the nights have observed."""
        rows = {row["name"]: row for row in document["repeatability"]}
        ev, ev_degrees = pooled(LOOKS)
        drill, drill_degrees = pooled(HOLES)
        self.check_scatter(rows[LOOKS], ev, ev_degrees)
        self.check_scatter(rows[HOLES], drill, drill_degrees)
        offsets = [[1e3 * parameter(entry, name) for entry, _, _ in counted()] for name in ("offset_x", "offset_y")]
        n = len(offsets[0])
        over = sum((one - sum(axis) / n) ** 2 for axis in offsets for one in axis) / (2 * (n - 1))
        within = 1e6 * sum(entry["covariance"][k][k] for entry, _, _ in counted() for k in range(2)) / (2 * n)
        av = max(0, over - within)
        (spindle,) = document["spindles"]
        gauge = spindle["gauge"]
        self.assertEqual([one["entry"] for one in spindle["nights"]], [entry["id"] for entry, _, _ in counted()])
        self.check_scatter(gauge["over_nights_um"], over, 2 * (n - 1))
        self.near(gauge["within_um"], math.sqrt(within))
        self.near(gauge["reproducibility_um"], math.sqrt(av), 1e-7)
        both = ev + av
        both_degrees = both ** 2 / (ev ** 2 / ev_degrees + (over ** 2 / (2 * (n - 1)) if av else 0))
        self.near(gauge["both_um"]["sigma"], math.sqrt(both))
        self.near(gauge["both_um"]["degrees_of_freedom"], both_degrees)
        self.near(gauge["percent_of_tolerance"], 100 * 6 * math.sqrt(both) / (2 * tolerance_um))
        newest = counted()[-1]
        offset = [1e6 * newest[0]["covariance"][k][k] for k in range(2)]
        parts = [[(offset[k], parameter(newest[1], "degrees of freedom: " + HOLES)), (ev, ev_degrees), (drill, drill_degrees)]
                 for k in range(2)]
        for axis in parts:
            axis += [(av, 2 * (n - 1) * (av / over) ** 2)] if av else []
        return spindle["budget"], parts

    def check_budget(self, budget, parts):
        for k in range(2):
            combined = math.sqrt(sum(one for one, _ in parts[k]))
            degrees = combined ** 4 / sum(one ** 2 / nu for one, nu in parts[k] if nu)
            self.near(budget["combined_um"][k], combined)
            self.near(budget["degrees_of_freedom"][k], degrees)
            self.near(budget["coverage_factor"][k], coverage_factor(degrees), 1e-5)
            self.near(budget["expanded_um"][k], budget["coverage_factor"][k] * combined)

    def test_figures_follow_from_the_records(self):
        golden_ledger.make("drill1.ledger", nights()).close()
        document = certificate()
        budget, parts = self.check_spindle(document, 40)
        self.check_budget(budget, parts)
        (spindle,) = document["spindles"]
        self.assertEqual((spindle["refused"], spindle["in_force"], document["verification"]["entries"]), (1, 13, 14))
        # B is the nights' mean, with the sigma of that mean; R is four times the rms of their scatters.
        figures = {(one["axis"], one["quantity"]): one for one in document["stage"]}
        backlash = [result["offsets"][0]["quality"]["backlash_um"][0] for _, _, result in counted()]
        mean = sum(backlash) / len(backlash)
        sigma = math.sqrt(sum((one - mean) ** 2 for one in backlash) / (len(backlash) - 1) / len(backlash))
        self.near(figures["x", "reversal"]["value"], mean / 1e3)
        self.near(figures["x", "reversal"]["sigma"], sigma / 1e3)
        scatter = [result["offsets"][0]["quality"]["repeatability_um"][0] for _, _, result in counted()]
        self.near(figures["x", "repeatability"]["value"], 4e-3 * math.sqrt(sum(one ** 2 for one in scatter) / len(scatter)))
        self.assertEqual(budget["missing"], ["table"])
        lacking = self.what_is_lacking(document)
        self.assertIn("deviation, straightness and squareness of the stage", lacking)
        self.assertIn("traceability to the unit of length", lacking)
        self.assertIn("ISO 230-2", lacking["bidirectional accuracy A, systematic deviation E and repeatability R of positioning"])

    def test_nights_of_the_machine_itself(self):
        for name in ("night/machine.toml", "camera-320-px/camera.cal.json"):
            shutil.copy(ROOT / "tests/golden/fixtures" / name, ".")
        for day in (20, 21, 22):
            subprocess.run([PANELCAL, "-q", "nightly", "-m", "machine.toml", "--clock", f"2026-11-{day}T02:00:00Z"],
                           capture_output=True, check=True, timeout=120)
        document = certificate()
        budget, parts = self.check_spindle(document, 12)
        self.check_budget(budget, parts)
        # [nightly.drift] says how far the offset may be off; the simulated stage repeats to 1 um, its drill to 3 um.
        self.assertEqual(document["tolerance"], {"limit_um": 12, "origin": "[nightly.drift] tolerance_um"})
        looks, holes = (next(row for row in document["repeatability"] if row["name"] == name) for name in (LOOKS, HOLES))
        self.assertTrue(looks["low"] < 1.05 and looks["high"] > 0.95, looks)
        self.assertTrue(holes["low"] < 3.2 and holes["high"] > 2.9, holes)
        self.assertGreater(len(document["verification"]["held_against"]), 0)

    def test_a_table_on_a_certified_plate_is_traceable(self):
        golden_ledger.make("drill1.ledger", [*nights(), table_entry()]).close()
        Path("table.cal.json").write_text(table_entry()[1], encoding="ascii")
        Path("machine.toml").write_text(MACHINE + '[tolerance]\nposition_um = 40\n[table]\ncalibration = "table.cal.json"\n'
                                        "[uncertainty]\ntable_residual_um = 0.8\n", encoding="ascii")
        document = certificate("--plate", "plate.toml")
        self.assertEqual(document["plate"]["sha256"], hashlib.sha256(PLATE.encode()).hexdigest())
        self.assertEqual((document["plate"]["certificate"], document["plate"]["expanded_uncertainty_um"], document["plate"]["entry"]),
                         ("123 of 2026", 0.6, 15))
        figures = {(one["axis"], one["quantity"]): one for one in document["stage"]}
        # 100 ppm over 400 by 300 mm; the bow is across.
        self.near(figures["x", "range"]["value"], 0.04)
        self.near(figures["y", "range"]["value"], 0.03)
        self.near(figures["xy", "squareness"]["value"], 3e-5)
        self.near(figures["y", "straightness_3"]["sigma"], 11e-6)
        rows = {row["source"]: row for row in document["spindles"][0]["budget"]["rows"]}
        self.assertEqual({source: rows[source]["type"] for source in ("map", "table", "plate")}, {"map": "A", "table": "B", "plate": "B"})
        self.near(rows["plate"]["sigma_um"][0], 0.3)
        budget, parts = self.check_spindle(document, 40)
        self.assertEqual(budget["missing"], [])
        self.check_budget(budget, [[*axis, (0.5 ** 2, None), (0.8 ** 2, None), (0.3 ** 2, None)] for axis in parts])
        self.assertNotIn("traceability to the unit of length", self.what_is_lacking(document))
        # Another map, of which the ledger does not say how it was made.
        golden_table.write("table.cal.json")
        document = certificate("--plate", "plate.toml")
        self.assertIn("entry 15", self.what_is_lacking(document)["traceability of the map in use"])
        self.assertNotIn("plate", [row["source"] for row in document["spindles"][0]["budget"]["rows"]])

    def test_another_plate_proves_nothing(self):
        golden_ledger.make("drill1.ledger", [*nights(), table_entry()]).close()
        for text, what, why in (
                (PLATE.replace("0.6", "0.1"), "traceability to the unit of length", "SHA-256"),
                (None, "traceability to the unit of length", "--plate")):
            if text:
                Path("plate.toml").write_text(text, encoding="ascii")
            document = certificate(*(["--plate", "plate.toml"] if text else []))
            self.assertIsNone(document["plate"])
            self.assertIn(why, self.what_is_lacking(document)[what])
        bare = PLATE.split("certificate =")[0]
        for text, what in ((bare, "uncertainty of plate \"B 17\""), (bare.replace("true", "false"), "traceability to the unit of length")):
            os.remove("drill1.ledger")
            golden_ledger.make("drill1.ledger", [*nights(), table_entry(text)]).close()
            Path("plate.toml").write_text(text, encoding="ascii")
            self.assertIn(what, self.what_is_lacking(certificate("--plate", "plate.toml")))

    def test_what_a_person_took_back_or_changed_does_not_count(self):
        all_of_it = nights()
        back = {**all_of_it[12][0], "verdict": "rolled-back", "reason": "holes are off", "replaces": 13, "restores": 11}
        fresh = {**all_of_it[0][0], "kind": "night", "subject": f"fresh start: spindle-camera {SUBJECT}", "verdict": "measured",
                 "parameters": [], "covariance": None}
        golden_ledger.make("drill1.ledger", [*all_of_it[:4], (fresh, "{}"), *all_of_it[4:]]).close()
        (spindle,) = certificate()["spindles"]
        self.assertEqual([one["entry"] for one in spindle["nights"]], [6, 8, 12, 14])
        self.assertEqual(spindle["fresh_start"], 5)
        os.remove("drill1.ledger")
        golden_ledger.make("drill1.ledger", [*all_of_it, (back, all_of_it[10][1])]).close()
        (spindle,) = certificate()["spindles"]
        self.assertEqual([one["entry"] for one in spindle["nights"]], [1, 3, 5, 7, 11])
        self.assertEqual((spindle["rolled_back"], spindle["in_force"]), (1, 11))
        (spindle,) = certificate("--since", "2026-11-03")["spindles"]
        self.assertEqual([one["entry"] for one in spindle["nights"]], [5, 7, 11])

    def test_a_ledger_without_nights_is_refused(self):
        golden_ledger.make("drill1.ledger", []).close()
        self.assertIn("error[ledger-entry-unknown]", run(code=2).stderr)
        os.remove("drill1.ledger")
        golden_ledger.make("drill1.ledger", night(1, 50, -3)).close()
        self.assertIn("1 installed calibration ", run(code=2).stderr)
        os.remove("drill1.ledger")
        run(code=2)
        # Two by hand: nothing has looked at a hole twice.
        golden_ledger.make("drill1.ledger", [night(i, 50, -3)[0] for i in (1, 2)]).close()
        document = certificate()
        self.assertEqual(document["repeatability"], [])
        self.assertEqual(document["spindles"][0]["budget"]["missing"], ["look", "drill", "table"])
        self.assertIsNone(document["spindles"][0]["gauge"])
        lacking = self.what_is_lacking(document)
        for what in (f"gauge R&R of {SUBJECT}", f"{LOOKS} ({SUBJECT})", f"{HOLES} ({SUBJECT})"):
            self.assertIn(what, lacking)

    def test_a_damaged_ledger_certifies_nothing(self):
        golden_ledger.make("drill1.ledger", nights()).close()
        whole = Path("drill1.ledger").read_bytes()
        for cut in (0, 50, 4096, len(whole) // 2, len(whole) - 4096):
            Path("drill1.ledger").write_bytes(whole[:cut])
            done = subprocess.run([PANELCAL, "history", "certificate", "-l", "drill1.ledger", "-m", "machine.toml", "--report", "page.html"],
                                  capture_output=True, text=True, timeout=120)
            self.assertIn(done.returncode, (2, 3), (cut, done))
            self.assertFalse(Path("page.html").exists())
            self.assertEqual(done.stdout, "")
        edited = whole.replace(b'"value":56,', b'"value":57,')
        self.assertTrue(edited != whole)
        Path("drill1.ledger").write_bytes(edited)
        self.assertIn("error[ledger-corrupt]", run(code=3).stderr)

    def test_names_of_others_stay_on_their_line(self):
        hostile = "<img src=x>\x1b[31m\n\u202e"
        golden_ledger.make("drill1.ledger", [one for i in (1, 2, 3) for one in night(i, 50, -3, subject=hostile, asked_by=hostile)]).close()
        text = run("--report", "page.html").stdout
        self.assertNotIn("\x1b", text)
        self.assertIn("<img src=x> [31m ", text)
        self.assertEqual(checked(in_page("page.html"), ROOT)["spindles"][0]["subject"], hostile)
        self.assertEqual(Path("page.html").read_text(encoding="utf-8").count("<img"), 0)

    def test_text_and_facts_agree(self):
        golden_ledger.make("drill1.ledger", nights()).close()
        text = run("--json", "facts.json", "-o", "certificate.txt").stdout
        self.assertEqual(text, "")
        text = Path("certificate.txt").read_text(encoding="utf-8")
        document = json.loads(Path("facts.json").read_text(encoding="utf-8"))
        x, y = document["spindles"][0]["budget"]["expanded_um"]
        self.assertRegex(text, rf"expanded U = k u +{x:.2f} +{y:.2f}\n")
        self.assertRegex(text, rf"6 R&R of the tolerance 2 T +{document['spindles'][0]['gauge']['percent_of_tolerance']:.1f} %")
        for one in document["not_measured"]:
            self.assertIn(f"  {one['what']}: {one['why']}\n", text)


if __name__ == "__main__":
    unittest.main()
