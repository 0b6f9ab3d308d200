// SPDX-License-Identifier: Apache-2.0
#include "tools/history/diff.h"

#include <cmath>
#include <complex>
#include <string>

#include "calib/camera/calibration/calibration_file.h"
#include "calib/table/calibration_file.h"
#include "tools/history/facts.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/table/table_of.h"
#include "tests/support/matchers.h"

namespace panelcal::history {
namespace {

using test::FailsWith;
using testing::HasSubstr;

/// Two holes before the targets, three targets, then two holes, a slot and an arc.
constexpr const char* kProgram =
    "M48\nMETRIC,TZ\nFMAT,2\nT1C0.800\nT2C1.000\n%\nG05\nG90\nT1\nX5.0Y5.0\nX6.0Y5.0\nG34,1\n"
    "G36X10.0Y10.0\nG36X110.0Y10.0\nG36X110.0Y90.0\nX20.0Y20.0\nX100.0Y80.0\n"
    "T2\nX50.0Y50.0G85X60.0Y50.0\nG00X30.0Y30.0\nM15\nG02X40.0Y40.0A10.0\nM16\nG05\nM30\n";
constexpr int kUncorrected = 2;

/// Sees every target as far from where it is expected as the panel is displaced.
class DisplacedPanel final : public MeasurementSource {
 public:
  explicit DisplacedPanel(const Eigen::Vector2d& by_mm) : by_mm_(by_mm) {}
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement m;
    m.request = request;
    m.status = MeasurementStatus::Found;
    m.measured = {position_mm<frame::Actual>(request.nominal.in_mm() + by_mm_),
                  1e-6 * Eigen::Matrix2d::Identity()};
    return m;
  }

 private:
  Eigen::Vector2d by_mm_;
};

struct Job {
  Program program;
  WalkOptions options;
  Survey before;
};

Job job_on(const Eigen::Vector2d& panel_mm) {
  DiagnosticLog log;
  Job job{load_program({"job.exc", kProgram}, log), {}, {}};
  DisplacedPanel panel(panel_mm);
  job.before = survey(job.program, job.options, panel, log);
  for (const Diagnostic& diagnostic : log.kept()) {
    EXPECT_NE(diagnostic.severity(), Severity::Error) << diagnostic.text();
  }
  return job;
}

LedgerEntry offset_entry(std::int64_t id, double x_mm, double y_mm) {
  LedgerEntry entry;
  entry.id = id;
  entry.record.key = {"drill 1", LedgerKind::SpindleCamera, "spindle 1 station 1"};
  entry.record.parameters = {{"offset_x", x_mm, "mm"}, {"offset_y", y_mm, "mm"}};
  return entry;
}

CameraCalibration camera(double scale_mm_per_px, double rotation_rad) {
  CameraCalibration calibration;
  calibration.parameters.scale_mm_per_px = scale_mm_per_px;
  calibration.parameters.rotation_rad = rotation_rad;
  calibration.parameters.axis_px = {320, 240};
  calibration.covariance.diagonal() << 1e-12, 1e-10, 1e-4, 1e-4, 1e-20;
  calibration.picture_width_px = 640;
  calibration.picture_height_px = 480;
  return calibration;
}

LedgerEntry camera_entry(std::int64_t id, const std::string& subject = "camera") {
  LedgerEntry entry;
  entry.id = id;
  entry.record.key = {"drill 1", LedgerKind::Camera, subject};
  return entry;
}

Expected<JobShift> shift_of(const Job& job, const Expected<CalibrationChange>& change) {
  if (!change) return failure(change.error());
  PANELCAL_TRY(const auto shift, job_shift(job.program, job.options, job.before, *change));
  if (!shift) return failure({Code::Usage, {}, "no places", ""});
  return *shift;
}

/// A change of the offset by (3, -4) um moves every corrected place by 5 um, whatever it is.
TEST(HistoryDiff, OffsetMovesAllThatTargetsPlace) {
  const Job job = job_on({0.4, -0.3});
  const LedgerEntry before = offset_entry(1, 50, -3);
  const LedgerEntry after = offset_entry(2, 50.003, -3.004);
  const auto shift = shift_of(job, change_between({before, ""}, {after, ""}, "x.ledger"));
  ASSERT_TRUE(shift) << shift.error().text();
  EXPECT_EQ(shift->n_still, static_cast<std::size_t>(kUncorrected));
  EXPECT_GT(shift->summary.n_holes, static_cast<std::size_t>(kUncorrected) + 4);
  EXPECT_EQ(shift->targets.size(), 3U);
  EXPECT_TRUE(shift->has_routs);
  EXPECT_FALSE(shift->is_uniform());
  constexpr double kRounding_mm = 1e-9;
  EXPECT_NEAR(shift->summary.max.in_mm(), 0.005, kRounding_mm);
  EXPECT_NEAR(shift->worst.shift.in_mm().x(), 0.003, kRounding_mm);
  EXPECT_NEAR(shift->worst.shift.in_mm().y(), -0.004, kRounding_mm);
  const double moved_part =
      1 - static_cast<double>(kUncorrected) / static_cast<double>(shift->summary.n_holes);
  EXPECT_NEAR(shift->summary.rms.in_mm(), 0.005 * std::sqrt(moved_part), kRounding_mm);
}

/// On a panel that lies t beside where it is expected, all targets are seen at t; a scale that is
/// 1 % larger and a camera turned by 1 mrad move them by 0.01 t and 0.001 t turned by 90 degrees.
TEST(HistoryDiff, CameraMovesTargetsByWhereTheyAreSeen) {
  const Job job = job_on({0.4, -0.3});
  const std::string before = camera_calibration_text(camera(0.01, 0));
  const std::string after = camera_calibration_text(camera(0.0101, 0.001));
  const auto shift = shift_of(
      job, change_between({camera_entry(1), before}, {camera_entry(2), after}, "x.ledger"));
  ASSERT_TRUE(shift) << shift.error().text();
  const std::complex<double> t(0.4, -0.3);
  const std::complex<double> expected = t * (1.01 * std::polar(1.0, 0.001) - 1.0);
  constexpr double kRounding_mm = 1e-8;
  EXPECT_NEAR(shift->worst.shift.in_mm().x(), expected.real(), kRounding_mm);
  EXPECT_NEAR(shift->worst.shift.in_mm().y(), expected.imag(), kRounding_mm);
}

/// No error, and then 1000 ppm of scale. A target at n + t that was seen from n - d is at
/// 1.001 (n - d) + d + t, which the panel's stretch takes up; what is told for a hole is a 1.001th
/// of where that puts it, n + (t - 0.001 d) / 1.001. So all corrected holes move by -(t + d) /
/// 1001.
TEST(HistoryDiff, TableMovesTargetsAndWhatIsToldForHoles) {
  const Job job = job_on({0.4, -0.3});
  const auto table = [](double ppm) {
    const TableGrid grid{Eigen::Vector2d(-1000, -1000), Eigen::Vector2d(1000, 1000), 2, 2};
    TableCalibration calibration;
    calibration.map = panelcal::test::table_of(
        grid, [ppm](const Eigen::Vector2d& c_mm) -> Eigen::Vector2d { return ppm * 1e-6 * c_mm; });
    calibration.geometry.cov.setIdentity();
    calibration.sigma = calibration.rms = um(1);
    calibration.provenance = "made up for a test";
    return table_calibration_text(calibration);
  };
  LedgerEntry before = camera_entry(1, "table");
  LedgerEntry after = camera_entry(2, "table");
  before.record.key.kind = after.record.key.kind = LedgerKind::Table;
  const std::string first = table(0);
  const std::string second = table(1000);
  const LookingMachine machine{{displacement_mm<frame::Machine>(50, -3), {}}, {}};
  const auto change = change_between({before, first}, {after, second}, "x.ledger", machine);
  ASSERT_TRUE(change) << change.error().text();
  // Seen with the spindle at expected - offset.
  const Measurement& target = job.before.measurements.at(1);
  const auto shift = change->target_shift(target);
  ASSERT_TRUE(shift) << shift.error().text();
  const Eigen::Vector2d command_mm =
      target.request.expected_in_machine().in_mm() - Eigen::Vector2d(50, -3);
  EXPECT_LT((shift->in_mm() - 1e-3 * command_mm).norm(), 1e-9);
  const auto moved = shift_of(job, change);
  ASSERT_TRUE(moved) << moved.error().text();
  EXPECT_EQ(moved->n_still, 0U);
  const Eigen::Vector2d expected_mm = -Eigen::Vector2d(50.4, -3.3) / 1001;
  EXPECT_LT((moved->worst.shift.in_mm() - expected_mm).norm(), 1e-7);
  // The same calibration twice moves nothing; a place beyond it cannot be told.
  const auto same = shift_of(job, change_between({before, first}, {after, first}, "x", machine));
  ASSERT_TRUE(same) << same.error().text();
  EXPECT_EQ(same->summary.max.in_mm(), 0);
  EXPECT_THAT(shift_of(job,
                       change_between({before, first},
                                      {after, second},
                                      "x",
                                      {{displacement_mm<frame::Machine>(5000, 0), {}}, {}})),
              FailsWith(Code::TravelExceeded, "x entry 1"));
}

TEST(HistoryDiff, ZoomMovesOnlyItsOwnTargets) {
  const Job job = job_on({0.4, -0.3});
  const std::string before = camera_calibration_text(camera(0.01, 0));
  const std::string after = camera_calibration_text(camera(0.0101, 0.001));
  const auto shift = shift_of(
      job,
      change_between(
          {camera_entry(1, "zoom 3"), before}, {camera_entry(2, "zoom 3"), after}, "x.ledger"));
  ASSERT_TRUE(shift) << shift.error().text();
  EXPECT_EQ(shift->summary.max.in_mm(), 0);
}

/// 4 mm are 400 px, and the picture ends 240 px from its axis.
TEST(HistoryDiff, RefusesTargetsOutsideOfThePicture) {
  const Job job = job_on({0, 4});
  const std::string text = camera_calibration_text(camera(0.01, 0));
  const auto shift =
      shift_of(job, change_between({camera_entry(1), text}, {camera_entry(2), text}, "x.ledger"));
  EXPECT_THAT(shift, FailsWith(Code::MeasurementMismatch));
}

/// The job's own offset is right whatever was stored, so that the true shift behind it is zero.
TEST(HistoryDiff, RefusesJobsThatCalibrateThemselves) {
  Job job = job_on({0, 0});
  CalibrationAnswer answer;
  answer.order.line = 11;
  answer.order.command = "G39";
  job.before.calibrations.push_back(answer);
  const LedgerEntry before = offset_entry(1, 50, -3);
  const LedgerEntry after = offset_entry(2, 50.02, -3);
  EXPECT_THAT(shift_of(job, change_between({before, ""}, {after, ""}, "x.ledger")),
              FailsWith(Code::Usage, "calibration 0 (G39, line 11)"));
}

TEST(HistoryDiff, RefusesTargetsWhoseViewNobodyKnows) {
  const std::string before = camera_calibration_text(camera(0.01, 0));
  const std::string after = camera_calibration_text(camera(0.0101, 0));
  const auto change = change_between({camera_entry(1), before}, {camera_entry(2), after}, "x");
  Job searched = job_on({0.4, -0.3});
  searched.before.measurements.at(1).request.settings.search = true;
  EXPECT_THAT(shift_of(searched, change), FailsWith(Code::MeasurementMismatch));
  Job slot = job_on({0.4, -0.3});
  slot.before.measurements.at(1).request.axes = ObservedAxes::X;
  EXPECT_THAT(shift_of(slot, change), FailsWith(Code::MeasurementMismatch));
}

TEST(HistoryDiff, RefusesWhatIsNoPair) {
  LedgerEntry before = offset_entry(1, 50, -3);
  LedgerEntry after = offset_entry(2, 50, -3);
  after.record.key.subject = "spindle 2 station 1";
  EXPECT_THAT(change_between({before, ""}, {after, ""}, "x.ledger"),
              FailsWith(Code::LedgerEntryInvalid, "spindle 2 station 1"));
  after = offset_entry(2, 50, -3);
  after.record.parameters[1].unit = "inch";
  EXPECT_THAT(change_between({before, ""}, {after, ""}, "x.ledger"),
              FailsWith(Code::LedgerEntryInvalid, "offset_y"));
  before.record.key.kind = after.record.key.kind = LedgerKind::Focus;
  EXPECT_THAT(change_between({before, ""}, {after, ""}, "x.ledger"),
              FailsWith(Code::LedgerEntryInvalid));
  EXPECT_THAT(change_between({camera_entry(1), "{}"}, {camera_entry(2), "{}"}, "x.ledger"),
              FailsWith(Code::CalibrationInvalid, "x.ledger entry 1"));
}

TEST(HistoryDiff, TextAndFactsAgree) {
  const Job job = job_on({0, 0});
  const LedgerEntry before = offset_entry(1, 50, -3);
  const LedgerEntry after = offset_entry(2, 50.003, -3.004);
  const auto shift = shift_of(job, change_between({before, ""}, {after, ""}, "x.ledger"));
  ASSERT_TRUE(shift);
  const JobShiftWords words{"job.exc", {"a note"}};
  const std::string text = job_shift_text(*shift, words);
  EXPECT_THAT(text, HasSubstr("largest shift 5.00 um"));
  EXPECT_THAT(text, HasSubstr("nothing moves, 2 places"));
  EXPECT_THAT(text, HasSubstr("note: a note\n"));
  const facts::Json json = job_shift_facts(*shift, words);
  EXPECT_EQ(json["max_mm"], 0.005);
  EXPECT_EQ(json["uncorrected"], 2);
  EXPECT_EQ(json["worst"]["shift_mm"][1], -0.004);
  EXPECT_EQ(json["notes"][0], "a note");
  EXPECT_EQ(json["targets_mm"].size(), 3U);
  EXPECT_EQ(json["outline_mm"].size(), shift->hull.size());
  // A place that targets correct moves by all of it, the others not at all.
  ASSERT_GT(json["sample"].size(), 2U);
  for (const facts::Json& one : json["sample"]) {
    const double length_mm =
        std::hypot(one["shift_mm"][0].get<double>(), one["shift_mm"][1].get<double>());
    EXPECT_TRUE(length_mm == 0 || std::abs(length_mm - 0.005) < 1e-9) << one;
  }
}

}  // namespace
}  // namespace panelcal::history
