// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/operator/desk.h"
#include "machine/operator/job_folder.h"
#include "machine/operator/picture_feed.h"
#include "program/model/measurement.h"
#include "program/walk/survey.h"

namespace panelcal::internal {

/// Answers as the source behind it does, and asks a person about a target that it did not find.
///
/// A measurement is in the job's folder before a screen shows it. What a person has decided is
/// marked in it (Measurement::decision), and stands in the folder's choices.
class OperatorSource final : public MeasurementSource {
 public:
  /// The parts of the station that it works with; all outlive it.
  struct Station {
    Desk& desk;
    JobFolder& folder;
    PictureFeed& feed;
    const MachineConfig& machine;
    const Survey& nominal;  ///< of the program's check: what the targets' series are
    const Clock& clock;
    int& n_questions;      ///< of the job so far
    bool may_skip = true;  ///< the language lets a series do without one of its targets
    bool may_jog = true;   ///< false: recorded pictures, which no movement changes
    bool is_live = false;  ///< the camera's picture changes by itself
    /// The reason why boards cannot be left out, by the measurements that would not be made;
    /// empty: they can be.
    std::function<std::string(const std::set<std::size_t>&)> why_not_leave_out = {};
  };

  /// In     eye: takes pictures for people; may be null
  ///        counted: measurements of this job that hold, by seq
  OperatorSource(const Station& station,
                 std::shared_ptr<MeasurementSource> source,
                 ViewTaker* eye,
                 std::map<std::int64_t, Measurement> counted);

  void foresee(RequestForecast forecast) override { source_->foresee(std::move(forecast)); }
  /// Fails  interrupted (a person has stopped the job, or the station closes); what the source
  ///        reports; device-write
  Expected<Measurement> measure(const MeasurementRequest& request) override;
  bool reconsiders() const override { return true; }
  Expected<std::optional<Measurement>> reconsider(const Contradiction& contradiction) override;
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override;
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override;
  DrilledPanel* drilled_panel() override { return source_->drilled_panel(); }
  Expected<void> finish() override { return source_->finish(); }

 private:
  Expected<void> check_stop() const;
  const Measurement* counted(const MeasurementRequest& request) const;
  void show(const Measurement& measurement);
  void show_looking(const MeasurementRequest& request);

  enum class Cause : std::uint8_t { NotFound, Contradicted };

  /// Asks until there is an answer that holds. Empty: the target stays as it is.
  Expected<std::optional<Measurement>> ask(const MeasurementRequest& request,
                                           Measurement lost,
                                           Cause cause);
  ScreenQuestion question_about(const MeasurementRequest& request,
                                const Measurement& lost,
                                Cause cause);
  /// States which lights the next look can have.
  void note_settings(ScreenQuestion& question) const;
  void offer_candidates(const Measurement& lost, ScreenQuestion& question);
  void offer_places(const MeasurementRequest& request, ScreenQuestion& question) const;
  std::string why_not_skip(const MeasurementRequest& request) const;
  std::string why_not_leave_board_out(const MeasurementRequest& request) const;
  /// The series of the check that holds a measurement; null: none.
  const SeriesResult* series_of(std::size_t seq) const;
  void note_left_out(const Measurement& answer);
  Expected<Answer> wait_for_answer(const MeasurementRequest& request);
  void jog(const MeasurementRequest& request, const Eigen::Vector2d& by_mm);
  void look_live(const MeasurementRequest& request, const View& view);

  Expected<Measurement> decide(const MeasurementRequest& request,
                               const Measurement& lost,
                               const Answer& answer);
  Expected<Measurement> look_again(MeasurementRequest request, const Answer& answer);
  Expected<Measurement> search(const MeasurementRequest& request, const Answer& answer);
  Measurement take_candidate(const Measurement& lost, std::size_t index) const;
  Measurement place_by_hand(const Eigen::Vector2d& at_px) const;

  Station at_;
  std::shared_ptr<MeasurementSource> source_;
  ViewTaker* eye_;
  std::map<std::int64_t, Measurement> counted_;
  std::vector<std::size_t> skipped_;
  std::set<std::size_t> left_out_;  ///< of series whose boards are left out
  Measurement board_answer_;        ///< of the last one's targets
  /// Of the open question: the measurement's candidate behind each that is offered.
  std::vector<std::size_t> offered_;
};

/// The end of a job that a person has stopped.
Diagnostic stopped();

/// The words by which a screen shows a measurement.
void show_measured(const Measurement& measurement, ScreenTarget& target);

}  // namespace panelcal::internal
