// SPDX-License-Identifier: Apache-2.0
#include "machine/doctor/doctor.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>

#include "calib/base/files/atomic_file.h"
#include "machine/init/machine_text.h"
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/devices/controls/grbl/fake_grbl.h"
#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr std::chrono::sys_seconds kNow = std::chrono::sys_days{2026y / 11 / 28};

/// A machine about which nothing is to be said.
constexpr std::string_view kSound = R"([machine]
name = "mill"
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 1
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [50, 0]
camera_offset_sigma_um = 5
camera_offset_date = 2026-11-20T00:00:00
[uncertainty]
stage_repeatability_um = 2
table_residual_um = 0
drill_wander_um = 3
[tolerance]
position_um = 50
)";

/// Lines of one state, "subject: text; remedy" each.
std::string lines(const Findings& findings, FindingState state) {
  std::string out;
  for (const Finding& finding : findings.all()) {
    if (finding.state != state) continue;
    out += fmt::format("{}: {}; {}\n", finding.subject, finding.text, finding.remedy);
  }
  return out;
}

/// A machine in a folder of its own.
class Doctor : public testing::Test {
 protected:
  Doctor() {
    CameraCalibration camera = test::test_camera(320, 240);
    camera.date = kNow - std::chrono::days(3);
    EXPECT_TRUE(write_camera_calibration(folder_.path() / "camera.cal.json", camera));
  }

  void write(std::string_view name, std::string_view text) {
    ASSERT_TRUE(write_file(folder_.path() / name, text));
  }

  Findings examine_text(std::string_view machine_toml, std::string camera = {}) {
    write("machine.toml", machine_toml);
    return examine({.machine_toml = folder_.path() / "machine.toml",
                    .camera = std::move(camera),
                    .opens_devices = opens_devices_,
                    .clock = fixed_clock(kNow),
                    .software = "test",
                    .asked_by = "test"});
  }
  std::string failures(std::string_view more, std::string camera = {}) {
    return lines(examine_text(std::string(kSound) + std::string(more), std::move(camera)),
                 FindingState::Fails);
  }
  std::string warnings(std::string_view more) {
    return lines(examine_text(std::string(kSound) + std::string(more)), FindingState::Warning);
  }
  std::string replaced(std::string_view old, std::string_view other) {
    std::string text(kSound);
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), other);
  }

  test::TemporaryFolder folder_;
  bool opens_devices_ = false;
};

TEST_F(Doctor, HasNothingAgainstASoundMachine) {
  const Findings findings = examine_text(kSound);
  EXPECT_THAT(lines(findings, FindingState::Fails), IsEmpty());
  EXPECT_THAT(lines(findings, FindingState::Warning), IsEmpty());
  EXPECT_THAT(lines(findings, FindingState::Ok),
              AllOf(HasSubstr("machine.toml: \"mill\""),
                    HasSubstr("camera.cal.json of 2026-11-25T00:00:00Z, 3.0 days ago"),
                    HasSubstr("spindle-camera offset: of 2026-11-20T00:00:00Z, 8.0 days ago"),
                    HasSubstr("MB are free")));
  EXPECT_THAT(lines(findings, FindingState::NotTried), HasSubstr("--camera ADDRESS"));
}

TEST_F(Doctor, NamesAFileThatIsMissingAndOneThatIsWrong) {
  std::filesystem::remove(folder_.path() / "camera.cal.json");
  EXPECT_THAT(failures(""), HasSubstr("camera.cal.json"));
  write("camera.cal.json", "{\n\"kind\": ");
  EXPECT_THAT(failures(""), HasSubstr("camera.cal.json:2"));
}

TEST_F(Doctor, NamesAKeyThatIsUnknownWithItsPlace) {
  EXPECT_THAT(failures("position_mm = 1\n"),
              AllOf(HasSubstr("machine.toml:19:"), HasSubstr("position_mm")));
}

TEST_F(Doctor, HoldsMachineTomlAgainstItself) {
  EXPECT_THAT(failures("[ledger]\nfile = \"a.ledger\"\n[nightly]\nmachine_driver = \"sim\"\n"
                       "[sim]\nseed = 1\n"),
              HasSubstr("[coupon]"));
}

TEST_F(Doctor, WarnsOfEachAssumedLine) {
  // A comment that speaks of such a line does not count.
  const std::string text = replaced("position_um = 50\n",
                                    "# \"assumed\" lines: a = 1 # assumed; no\n"
                                    "position_um = 50   # assumed; ask for it\n");
  EXPECT_EQ(lines(examine_text(text), FindingState::Warning),
            "machine.toml line 19: position_um = 50 is assumed, not measured; ask for it\n");
}

TEST_F(Doctor, KnowsTheAssumedFilesOfInit) {
  const MachineAnswers answers{.kind = MachineKind::Folder};
  ASSERT_TRUE(
      write_camera_calibration(folder_.path() / kAssumedCameraFile, assumed_camera(answers, kNow)));
  const Findings findings = examine_text(machine_text(answers, "machine.toml"));
  EXPECT_THAT(lines(findings, FindingState::Warning),
              AllOf(HasSubstr("camera: "), HasSubstr("assumed, not measured; panelcal calibrate")));
  EXPECT_THAT(lines(findings, FindingState::Fails),
              AllOf(HasSubstr("every job is held"), HasSubstr("most of it by the camera")));
}

TEST_F(Doctor, HoldsTheSmallestErrorOfAHoleAgainstTheTolerance) {
  // Of one axis: sqrt(5^2 + 2^2 + 3^2) = 6.16; P(|e| > 50 um) = exp(-50^2 / (2 * 38)) = 5e-15.
  EXPECT_THAT(lines(examine_text(kSound), FindingState::Ok),
              AllOf(HasSubstr("a hole's sigma is 6.2 um"), HasSubstr("most of it by the spindle")));
  // exp(-24^2 / 76) = 5e-4: above the 1e-4 that warn, below the 1e-2 that hold.
  EXPECT_THAT(
      lines(examine_text(replaced("position_um = 50", "position_um = 24")), FindingState::Warning),
      HasSubstr("with probability 0.0005"));
  EXPECT_THAT(
      lines(examine_text(replaced("camera_offset_sigma_um = 5", "camera_offset_sigma_um = 30")),
            FindingState::Fails),
      AllOf(HasSubstr("every job is held"), HasSubstr("calibrate spindle-camera")));
}

TEST_F(Doctor, MissesWhatRisksAreMadeOf) {
  EXPECT_THAT(lines(examine_text(replaced("drill_wander_um = 3\n", "")), FindingState::Warning),
              HasSubstr("[uncertainty] lacks drill wander"));
  EXPECT_THAT(
      lines(examine_text(replaced("[tolerance]\nposition_um = 50\n", "")), FindingState::Warning),
      HasSubstr("[tolerance] position_um is missing"));
  EXPECT_THAT(lines(examine_text(replaced("camera_offset_date = 2026-11-20T00:00:00\n", "")),
                    FindingState::Warning),
              HasSubstr("without a date"));
}

TEST_F(Doctor, RefusesAnOffsetOfTheFuture) {
  EXPECT_THAT(lines(examine_text(replaced("2026-11-20", "2026-12-20")), FindingState::Fails),
              HasSubstr("2026-12-20"));
}

TEST_F(Doctor, NamesAnOffsetThatWasNeverCalibrated) {
  EXPECT_THAT(lines(examine_text(replaced("camera_offset_sigma_um = 5\n"
                                          "camera_offset_date = 2026-11-20T00:00:00\n",
                                          "calibration = \"spindle.cal.json\"\n")),
                    FindingState::Fails),
              HasSubstr("spindle.cal.json does not have spindle 1"));
}

TEST_F(Doctor, FindsProgramsAsTheyAreStarted) {
  const auto with_move = [](std::string_view program) {
    return fmt::format(
        "[machine]\nname = \"mill\"\nstage_command = [\"{}\", \"{{x}}\", \"{{y}}\"]\n", program);
  };
  const std::string_view head = "[machine]\nname = \"mill\"\n";
  EXPECT_THAT(lines(examine_text(replaced(head, with_move("sh"))), FindingState::Ok),
              HasSubstr("program [machine] stage_command: /"));
  EXPECT_THAT(
      lines(examine_text(replaced(head, with_move("no-such-program"))), FindingState::Fails),
      HasSubstr("\"no-such-program\" is in no folder of PATH"));
  write("script", "#!/bin/sh\n");
  const std::string script = (folder_.path() / "script").string();
  EXPECT_THAT(lines(examine_text(replaced(head, with_move(script))), FindingState::Fails),
              HasSubstr("cannot be executed"));
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  EXPECT_THAT(lines(examine_text(replaced(head, with_move(script))), FindingState::Fails),
              IsEmpty());
}

TEST_F(Doctor, ReadsTheWholeLedger) {
  constexpr std::string_view kLedger = "[ledger]\nfile = \"mill.ledger\"\n";
  EXPECT_THAT(lines(examine_text(std::string(kSound) + std::string(kLedger)), FindingState::Ok),
              HasSubstr("is not there yet"));
  write("mill.ledger",
        "no database, and long enough to look like one that is damaged: 0123456789"
        "0123456789012345678901234567890123456789012345678901234567890123456789");
  EXPECT_THAT(failures(kLedger), HasSubstr("ledger: "));
  EXPECT_THAT(failures("[ledger]\nfile = \"camera.cal.json/mill.ledger\"\n"),
              HasSubstr("cannot be written"));
}

TEST_F(Doctor, TakesAPictureOnlyWhereItMayOpenTheCamera) {
  EXPECT_THAT(failures("", "v4l2:/dev/no-camera"),
              AllOf(HasSubstr("/dev/no-camera"), HasSubstr("adduser")));
  EXPECT_THAT(failures("", "folder:no-folder"), HasSubstr("is no folder"));
  EXPECT_THAT(failures("", "camera"), HasSubstr("camera-uri"));
  const auto pictures = folder_.path() / "pictures";
  std::filesystem::create_directory(pictures);
  const std::string uri = "folder:" + pictures.string();
  EXPECT_THAT(failures("", uri), IsEmpty());
  opens_devices_ = true;
  EXPECT_THAT(failures("", uri), HasSubstr("camera device")) << "there is no picture";
  const std::string head = "P5 320 240 255\n";
  write("pictures/1.pgm", head + std::string(320 * 240, 'x'));
  EXPECT_THAT(failures("", uri), Not(HasSubstr("the calibration is of")));
}

TEST_F(Doctor, TriesTheControlAndMovesNothing) {
  FakeGrbl idle({});
  FakeGrbl locked({.state = "Alarm"});
  const auto with_grbl = [&](const FakeGrbl& control) {
    return replaced(
        "name = \"mill\"\n",
        fmt::format("name = \"mill\"\ndriver = \"grbl\"\nhost = \"127.0.0.1\"\nport = {}\n"
                    "safe_z_mm = -5\nhoming = \"when_locked\"\n",
                    control.port()));
  };
  EXPECT_THAT(lines(examine_text(with_grbl(idle)), FindingState::NotTried),
              HasSubstr("control: 127.0.0.1 is not opened; --devices"));
  EXPECT_EQ(idle.n_messages(), 0);
  opens_devices_ = true;
  EXPECT_THAT(lines(examine_text(with_grbl(idle)), FindingState::Ok),
              HasSubstr("control: GRBL 1.1h"));
  EXPECT_THAT(lines(examine_text(with_grbl(locked)), FindingState::Fails), HasSubstr("locked"));
  for (const FakeGrbl* control : {&idle, &locked}) {
    for (const std::string& line : control->received()) {
      EXPECT_THAT(line, AllOf(Not(HasSubstr("$J")), Not(HasSubstr("$H")), Not(HasSubstr("$X"))));
    }
  }
}

TEST_F(Doctor, NamesASerialDeviceThatIsNotThere) {
  EXPECT_THAT(lines(examine_text(replaced("name = \"mill\"\n",
                                          "name = \"mill\"\ndriver = \"grbl\"\ndevice = "
                                          "\"/dev/no-tty\"\nsafe_z_mm = -5\n")),
                    FindingState::Fails),
              AllOf(HasSubstr("/dev/no-tty"), HasSubstr("dialout")));
}

constexpr std::string_view kNight = R"([coupon]
name = "A"
origin_mm = [300, 100]
pitch_mm = 2
columns = 3
rows_per_run = 3
rows = 30
[ledger]
file = "mill.ledger"
[nightly]
machine_driver = "sim"
reports = "nights"
[sim]
picture_px = [320, 240]
)";

TEST_F(Doctor, SaysWhatTheNightWouldDo) {
  const std::string with_file = replaced(
                                    "camera_offset_sigma_um = 5\n"
                                    "camera_offset_date = 2026-11-20T00:00:00\n",
                                    "calibration = \"spindle.cal.json\"\n") +
                                std::string(kNight);
  const Findings findings = examine_text(with_file);
  EXPECT_THAT(lines(findings, FindingState::Ok),
              AllOf(HasSubstr("tonight disk: "),
                    HasSubstr("tonight spindle-camera spindle 1 station 1: would be measured"),
                    HasSubstr("reports: ")))
      << lines(findings, FindingState::Fails);
  EXPECT_THAT(lines(findings, FindingState::NotTried), IsEmpty()) << "the machine is simulated";
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "mill.ledger"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "nights"));
}

TEST_F(Doctor, SaysThatTheNightHasNoRoomOnTheDiskOrForItsReports) {
  std::string night(kNight);
  night.insert(night.find("reports"), "min_disk_mb = 1e9\n");
  const std::string base = replaced(
      "camera_offset_sigma_um = 5\n"
      "camera_offset_date = 2026-11-20T00:00:00\n",
      "calibration = \"spindle.cal.json\"\n");
  EXPECT_THAT(lines(examine_text(base + night), FindingState::Fails), HasSubstr("tonight disk: "));
  night = kNight;
  night.replace(night.find("reports = \"nights\""), 18, "reports = \"camera.cal.json/x\"");
  EXPECT_THAT(lines(examine_text(base + night), FindingState::Fails), HasSubstr("reports: "));
}

TEST_F(Doctor, SaysWhyANightWouldNotBegin) {
  EXPECT_THAT(failures("[nightly]\nmachine_driver = \"sim\"\n[sim]\nseed = 1\n"),
              HasSubstr("tonight: the night would not begin: "));
}

}  // namespace
}  // namespace panelcal
