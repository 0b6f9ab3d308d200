#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A new kind of calibration is one file and one row: machine/calibrate/kinds/NAME.cc, and
PANELCAL_CALIBRATION in calib/ledger/entry/kinds.def (docs/overview.md, "A calibration").

    add_calibration_kind_test.py REPOSITORY BUILD MODULES

Adds a toy kind in a folder that lies over the repository, compiles its file and the two tables made
of the rows, links them ahead of the built libraries, and runs nights of it: measured, judged,
recorded, installed, shown by `history`, refused when it has moved.
"""
import json
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROW = 'PANELCAL_CALIBRATION(Toy, "toy", 8, false, toy_calibrations)\n'

TOY = r"""// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "machine/calibrate/kinds/parts.h"

namespace panelcal {
namespace {

/// Where the stage comes to rest when it is sent home.
class ToyKind final : public Calibration {
 public:
  explicit ToyKind(std::shared_ptr<MachineConfig> config) : config_(std::move(config)) {}

  LedgerKey key() const override { return {machine_name(*config_), LedgerKind::Toy, "stage"}; }
  std::vector<std::string> axes() const override { return {"home x", "home y"}; }
  std::filesystem::path file() const override {
    return config_->file.parent_path() / "toy.cal.json";
  }
  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override {
    constexpr std::array<std::string_view, 2> kNames = {"home_x", "home_y"};
    return values_of(entry.record, kNames);
  }
  Expected<CalibrationResult> measure(const CalibrationDevices& devices,
                                      const RecordWords& words) override {
    PANELCAL_TRY(const auto standing, devices.stage.move_to(position_mm<frame::Machine>(0, 0)));
    const char* moved = std::getenv("TOY_MOVED_MM");
    const Eigen::Vector2d home_mm =
        standing.in_mm() + Eigen::Vector2d(moved != nullptr ? std::atof(moved) : 0, 0);
    CalibrationResult out;
    out.result.point.value = home_mm;
    out.result.point.cov = 1e-6 * Eigen::Matrix2d::Identity();
    out.result.used = "moves";
    out.result.n_used = 5;
    out.report = {"the stage was sent home"};
    PANELCAL_TRY(out.draft, draft_of(*config_, key(), words));
    out.draft.record.parameters = {{"home_x", home_mm.x(), "mm"}, {"home_y", home_mm.y(), "mm"}};
    out.draft.record.covariance = out.result.point.cov;
    const nlohmann::ordered_json file = {{"kind", "toy"}, {"home_mm", {home_mm.x(), home_mm.y()}}};
    out.draft.result = file.dump(2) + "\n";
    return out;
  }

 protected:
  std::string_view thing() const override { return "a toy"; }

 private:
  std::shared_ptr<MachineConfig> config_;
};

}  // namespace

namespace internal {

Expected<Calibrations> toy_calibrations(LedgerKind /*kind*/,
                                        const std::shared_ptr<MachineConfig>& config,
                                        const NightlyConfig& /*nightly*/) {
  return only_calibration(std::make_unique<ToyKind>(config));
}

}  // namespace internal
}  // namespace panelcal
"""

NIGHTS = """[ledger]
file = "drill1.ledger"
[nightly]
machine_driver = "sim"
calibrate = ["toy"]
min_disk_mb = 0
"""


def add_kind(root, overlay):
    """Writes the one file and the one row."""
    kinds_def = Path("calib/ledger/entry/kinds.def")
    rows = (root / kinds_def).read_text(encoding="utf-8")
    (overlay / kinds_def).parent.mkdir(parents=True)
    (overlay / kinds_def).write_text(rows.replace("\n#undef", "\n" + ROW + "\n#undef", 1), encoding="utf-8")
    toy = overlay / "machine/calibrate/kinds/toy.cc"
    toy.parent.mkdir(parents=True)
    toy.write_text(TOY, encoding="utf-8")
    return toy


def unit_of(commands, source):
    """What the compiler is given to compile a source: itself, or a file that includes several."""
    for entry in commands:
        file = Path(entry["file"])
        if file.as_posix().endswith(source) or f'"{source}"' in file.read_text(encoding="utf-8", errors="replace"):
            return file
    raise AssertionError(f"nothing compiles {source}")


def build(root, overlay, build_folder):
    """The program with the toy kind; everything else as it was built."""
    toy = add_kind(root, overlay)
    commands = json.loads((build_folder / "compile_commands.json").read_text(encoding="utf-8"))
    kinds = unit_of(commands, "machine/calibrate/kinds/kinds.cc")
    # What is compiled in one unit with the words of kinds knows them too.
    units = [kinds, *{unit_of(commands, f"calib/ledger/entry/{name}.cc") for name in ("entry", "entry_text")}]
    own = next(entry for entry in commands if Path(entry["file"]) == kinds)
    words = shlex.split(own["command"])
    begin = words[:words.index("-o")]
    compiler = next(i for i, word in enumerate(begin) if not word.endswith("ccache")) + 1
    begin[compiler:compiler] = ["-I", str(overlay)]
    running, objects = [], []
    for source in [toy, *units]:
        objects.append(str(overlay / (source.stem + ".o")))
        # Optimizing takes half of the time, and nothing here is slow.
        command = [*begin, "-O0", "-U_FORTIFY_SOURCE", "-o", objects[-1], "-c", str(source)]
        running.append(subprocess.Popen(command, cwd=own["directory"]))
    assert all(compiling.wait() == 0 for compiling in running), "the toy kind does not compile"
    link = subprocess.run(["ninja", "-t", "commands", "panelcal"], cwd=build_folder, check=True,
                          capture_output=True, text=True).stdout.splitlines()[-1]
    words = shlex.split(link)
    words = words[words.index("&&") + 1:]
    words = words[:words.index("&&")]
    program = overlay / "panelcal"
    words[words.index("-o") + 1] = str(program)
    first = next(i for i, word in enumerate(words) if word.endswith(".o"))
    subprocess.run([*words[:first], *objects, *words[first:]], cwd=build_folder, check=True)
    return program


class Machine:
    """A virtual machine in a folder, and the program with the toy kind."""

    def __init__(self, root, folder, program):
        self.folder, self.program = folder, program
        fixtures = root / "tests/golden/fixtures"
        text = (fixtures / "spindle-camera/machine.toml").read_text(encoding="utf-8")
        (folder / "machine.toml").write_text(text + NIGHTS, encoding="utf-8")
        shutil.copy(fixtures / "camera-200-px/camera.cal.json", folder)

    def panelcal(self, *words, code=0, **environment):
        done = subprocess.run([self.program, *words], cwd=self.folder, capture_output=True, text=True,
                              timeout=60, env=environment)
        assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
        return done.stdout

    def night(self, day, code=0, **environment):
        return self.panelcal("nightly", "-m", "machine.toml", "--clock", f"2026-11-{day}T02:00:00Z",
                             code=code, **environment)


def check(machine):
    said = machine.night(20)
    assert "toy stage: installed: the first one" in said, said
    assert json.loads((machine.folder / "toy.cal.json").read_text())["kind"] == "toy"
    assert "installed" in machine.night(21)
    # Half a millimetre is no home: the gate on the change speaks, knowing no kind by name.
    said = machine.night(22, 1, TOY_MOVED_MM="0.5")
    assert "toy stage: hold" in said or "toy stage: keep" in said, said
    listed = machine.panelcal("history", "list", "-l", "drill1.ledger", "--kind", "toy")
    assert [line.split("  ")[-1].split(":")[0].strip() for line in listed.splitlines()] == [
        "installed", "installed", "refused"], listed
    plot = machine.panelcal("history", "plot", "-l", "drill1.ledger", "--machine", "drill 1", "--kind",
                            "toy", "--subject", "stage", "--parameter", "home_x")
    assert plot.count("installed") == 2 and plot.count("refused") == 1, plot
    machine.panelcal("history", "rollback", "-l", "drill1.ledger", "--machine", "drill 1", "--kind",
                     "toy", "--subject", "stage", "--reason", "the first one was better")
    (machine.folder / "toy.cal.json").unlink()
    said = machine.night(23)
    assert "written again from the ledger" in said, said
    machine.panelcal("check", "-m", "machine.toml")


def main():
    root, build_folder, modules = (Path(word).resolve() for word in sys.argv[1:4])
    with tempfile.TemporaryDirectory() as name:
        overlay = Path(name) / "overlay"
        program = build(root, overlay, build_folder)
        for module in modules.glob("*.so"):
            (overlay / module.name).symlink_to(module)
        folder = Path(name) / "machine"
        folder.mkdir()
        check(Machine(root, folder, program))


main()
