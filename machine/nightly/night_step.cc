// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/night_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "calib/drift/amount.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/nightly/night_outlook.h"
#include "machine/nightly/night_quality.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

NightStep begin_step(const Calibration& calibration) {
  const LedgerKey key = calibration.key();
  NightStep step;
  step.kind = std::string(word(key.kind));
  step.subject = key.subject;
  step.file = calibration.file();
  for (const std::string& axis : calibration.axes()) {
    NightAxis& out = step.axes.emplace_back();
    out.name = axis;
    out.unit = calibration.unit();
  }
  return step;
}

NightStep fail(NightStep step, Diagnostic problem) {
  step.state = NightState::Failed;
  step.summary = problem.code == Code::Interrupted ? "interrupted: " + problem.what
                                                   : "failed: " + problem.message();
  step.problem = std::move(problem);
  return step;
}

bool is_of_a_device(const Diagnostic& problem) {
  const Fault fault = info(problem.code).fault;
  return fault == Fault::Device || fault == Fault::Internal;
}

void say(const NightContext& context, const std::string& line) {
  if (context.job.progress) context.job.progress(line);
}

/// Value with which holes are drilled: of the ledger, or where that has nothing, of the files.
std::optional<Eigen::VectorXd> in_force_of(const NightHistory& history,
                                           const Calibration& calibration) {
  if (history.in_force_value) return history.in_force_value->value;
  return calibration.present();
}

void fill_old(const NightHistory& history,
              const std::optional<Eigen::VectorXd>& in_force,
              NightStep& step) {
  if (history.in_force) step.in_force_id = history.in_force->id;
  if (!in_force) return;
  for (std::size_t i = 0; i < step.axes.size(); ++i) {
    step.axes[i].old_value = (*in_force)(static_cast<Eigen::Index>(i));
  }
}

void fill_new(const LedgerValues& found,
              const std::optional<Eigen::VectorXd>& in_force,
              NightStep& step) {
  for (std::size_t i = 0; i < step.axes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    step.axes[i].new_value = found.value(row);
    step.axes[i].new_sigma = std::sqrt(std::max(0.0, found.cov(row, row)));
  }
  if (!in_force) return;
  const Eigen::VectorXd change = found.value - *in_force;
  step.change = change.norm();
  // Along the change; where there is none, the largest.
  step.change_sigma = *step.change > 0
                          ? std::sqrt(std::max(0.0, change.dot(found.cov * change))) / *step.change
                          : std::sqrt(found.cov.diagonal().maxCoeff());
}

/// decide_night with further gates that refuse.
Expected<NightDecision> decide(const NightContext& context,
                               const NightHistory& history,
                               const NightResult& result,
                               const std::optional<Eigen::VectorXd>& in_force,
                               const std::vector<NightGate>& refusing) {
  const NightlyConfig& config = context.nightly;
  PANELCAL_TRY(const DriftSeries series, series_as_learned(history, config));
  PANELCAL_TRY(NightDecision decision,
               decide_night(result, in_force, series, config.drift, config.limits));
  if (refusing.empty()) return decision;
  if (decision.verdict == NightVerdict::Install) {
    // The fate of the old one is then decided as if the night had found nothing.
    NightResult nothing = result;
    nothing.point.is_left_out = true;
    PANELCAL_TRY(const NightDecision kept,
                 decide_night(nothing, in_force, series, config.drift, config.limits));
    decision.verdict = kept.verdict;
    decision.old = kept.old;
    if (!kept.reasons.empty()) decision.reasons = {kept.reasons.back()};
  }
  std::vector<std::string> reasons;
  for (const NightGate& gate : refusing) {
    decision.gates.push_back(gate);
    reasons.push_back(gate.text);
  }
  decision.reasons.insert(decision.reasons.begin(), reasons.begin(), reasons.end());
  return decision;
}

NightState state_of(NightVerdict verdict) {
  switch (verdict) {
    case NightVerdict::Install:
      return NightState::Installed;
    case NightVerdict::KeepOld:
      return NightState::KeptOld;
    case NightVerdict::Hold:
      break;
  }
  return NightState::Held;
}

std::string summary_of(const NightStep& step) {
  if (step.state != NightState::Installed) return step.decision->summary();
  if (!step.change) return "installed: the first one";
  const std::string& unit = step.axes.front().unit;
  return fmt::format("installed: {} from the one before (sigma {})",
                     amount(*step.change, unit),
                     amount(*step.change_sigma, unit));
}

/// Either clock may be wrong: only a person can tell, and says so with the command that stands
/// here.
std::string ahead_text(const NightHistory& history,
                       const LedgerKey& key,
                       const std::filesystem::path& ledger) {
  constexpr double kHour_s = 3600;
  return fmt::format(
      "entry {} of the ledger is {:.1f} hours ahead of the clock: set the clock if it is wrong; if "
      "it was wrong then, `panelcal history fresh-start -l {} --machine {} --kind {} --subject {} "
      "--reason \"the clock was wrong\"`, and the next night is measured again",
      history.ahead_id,
      static_cast<double>(history.ahead->count()) / kHour_s,
      quoted(ledger.string(), 200),
      quoted(key.machine),
      word(key.kind),
      quoted(key.subject));
}

/// Everything about one calibration of one night.
class Step {
 public:
  /// In     ledger: null where there is none yet, to foresee
  Step(const NightContext& context, Calibration& calibration, Ledger* ledger)
      : context_(context),
        calibration_(calibration),
        ledger_(ledger),
        step_(begin_step(calibration)) {}

  NightStep run() {
    Expected<void> done = look_back();
    if (done && history_.ahead) {
      done = hold_for_the_clock();
    } else if (done) {
      done = is_done_before() ? restore() : measure_and_decide();
    }
    if (!done) return fail(std::move(step_), std::move(done).error());
    return std::move(step_);
  }

  /// What there is, and what would be done.
  NightStep foresee() {
    step_.state = NightState::WouldRun;
    Expected<void> done = look_ahead();
    if (!done) return fail(std::move(step_), std::move(done).error());
    return std::move(step_);
  }

 private:
  std::string title() const { return step_.kind + " " + step_.subject; }

  Expected<void> look_ahead() {
    PANELCAL_CHECK(look_back());
    step_.summary = is_done_before()
                        ? "this night has done it already: nothing would be measured"
                        : "would be measured, judged and, if every gate passes, installed";
    std::string obstacle;
    if (history_.ahead) {
      obstacle = ahead_text(history_, calibration_.key(), context_.job.config.ledger_file);
    }
    if (!context_.no_measuring.empty()) obstacle = context_.no_measuring;
    if (!obstacle.empty()) step_.summary = "would not be measured: " + obstacle;
    DriftPoint point;
    point.time = words_.date;
    point.is_left_out = true;
    return fill_outlook(history_, {point, false}, in_force_, context_.nightly, step_);
  }

  Expected<void> look_back() {
    words_ = {.date = context_.job.clock(),
              .asked_by = context_.job.asked_by,
              .software = context_.job.software,
              .temperature_degC = context_.temperature_c};
    if (ledger_ != nullptr) {
      PANELCAL_TRY(history_,
                   read_night_history(*ledger_, calibration_, context_.night, words_.date));
    } else {
      history_.series = {calibration_.axes(), calibration_.unit(), {}};
    }
    accept_moves_by_hand(history_, context_.nightly.limits.change);
    in_force_ = in_force_of(history_, calibration_);
    fill_old(history_, in_force_, step_);
    point_.time = words_.date;
    if (!history_.series.points.empty()) {
      point_.time =
          std::max(point_.time, history_.series.points.back().time + std::chrono::seconds(1));
    }
    point_.temperature_c = context_.temperature_c;
    point_.is_fresh_start = history_.is_fresh_start;
    point_.is_left_out = true;
    return {};
  }

  /// Nothing is measured: it would be recorded with a time that is not valid.
  Expected<void> hold_for_the_clock() {
    step_.state = NightState::Held;
    step_.summary = ahead_text(history_, calibration_.key(), context_.job.config.ledger_file);
    return finish();
  }

  bool is_done_before() const { return history_.tonight && !context_.job.is_again; }

  Expected<void> restore() {
    step_.is_from_earlier_run = true;
    step_.state = history_.tonight->state;
    step_.summary = history_.tonight->summary;
    step_.ledger_id = history_.tonight->entry.id;
    const bool is_replaced = step_.state == NightState::Installed && history_.in_force &&
                             history_.in_force->id != step_.ledger_id;
    if (is_replaced) {
      step_.state = NightState::KeptOld;
      step_.summary = fmt::format(
          "entry {}, which this night installed, was {} since: entry {} is "
          "in force",
          *step_.ledger_id,
          history_.in_force->id < *step_.ledger_id ? "rolled back" : "replaced",
          history_.in_force->id);
    }
    const auto found = calibration_.value_of(history_.tonight->entry);
    if (found) {
      const auto before = in_force_before(history_.tonight->entry.id);
      for (NightAxis& axis : step_.axes) axis.old_value.reset();
      fill_old(history_, before, step_);
      fill_new(*found, before, step_);
    }
    say(context_, title() + ": done by an earlier run of this night");
    NightPlace place = {point_, found.has_value()};
    if (found) place.point = history_.series.points.back();
    return fill_outlook(history_, place, in_force_, context_.nightly, step_);
  }

  /// Value that was in force before an entry that has a place in the series.
  std::optional<Eigen::VectorXd> in_force_before(std::int64_t id) const {
    const auto at = std::ranges::find(history_.ids, id);
    if (at == history_.ids.begin() || at == history_.ids.end()) return std::nullopt;
    return history_.in_force_values[static_cast<std::size_t>(at - history_.ids.begin() - 1)];
  }

  Expected<void> measure_and_decide() {
    if (!context_.no_measuring.empty()) {
      return decide_without({Code::CalibrationData, {}, context_.no_measuring, ""}, false);
    }
    say(context_, title() + ": measuring");
    Expected<CalibrationResult> found = calibration_.measure(context_.job.devices, words_);
    if (!found && is_of_a_device(found.error())) return failure(std::move(found).error());
    if (!found) {
      // A problem before anything is measured (no coupon is left) leaves the night open.
      const bool is_measured = found.error().code == Code::CalibrationData ||
                               info(found.error().code).fault == Fault::Gate;
      return decide_without(std::move(found).error(), is_measured);
    }
    measurement_ = *std::move(found);
    return decide_with();
  }

  /// Nothing was found: the old one may stay or not.
  Expected<void> decide_without(Diagnostic problem, bool is_recorded) {
    NightResult nothing;
    nothing.point = point_;
    PANELCAL_TRY(NightDecision decision, decide(context_, history_, nothing, in_force_, {}));
    if (!decision.gates.empty()) decision.gates.front().text = problem.message();
    if (!decision.reasons.empty()) decision.reasons.front() = problem.message();
    step_.problem = std::move(problem);
    step_.decision = std::move(decision);
    step_.state = state_of(step_.decision->verdict);
    step_.summary = summary_of(step_);
    LedgerDraft draft;
    draft.record.key = calibration_.key();
    draft.result = "{\"kind\": \"nothing-found\", \"version\": 1}\n";
    if (is_recorded) PANELCAL_CHECK(record(std::move(draft), nullptr));
    return finish();
  }

  Expected<void> decide_with() {
    DriftPoint& point = measurement_.result.point;
    point.time = point_.time;
    point.temperature_c = point_.temperature_c;
    point.is_fresh_start = point_.is_fresh_start;
    point.is_left_out = false;
    std::vector<NightGate> refusing;
    PANELCAL_CHECK(judge(refusing));
    PANELCAL_TRY(step_.decision,
                 decide(context_, history_, measurement_.result, in_force_, refusing));
    step_.state = state_of(step_.decision->verdict);
    point_ = point;
    point_.is_left_out = step_.state != NightState::Installed;
    const bool is_sound = point.value.size() == static_cast<Eigen::Index>(step_.axes.size()) &&
                          point.cov.rows() == point.value.size() &&
                          point.cov.cols() == point.value.size();
    if (is_sound) fill_new({point.value, point.cov}, in_force_, step_);
    step_.holes = measurement_.holes;
    step_.surface = measurement_.surface;
    step_.fit_report = measurement_.report;
    step_.summary = summary_of(step_);
    PANELCAL_CHECK(record(std::move(measurement_.draft), &measurement_));
    return finish();
  }

  Expected<void> judge(std::vector<NightGate>& refusing) {
    if (history_.is_unconfirmed) {
      refusing.push_back({"ledger",
                          false,
                          "the ledger was damaged and begun anew: a person has to look, and mark a "
                          "fresh start"});
    }
    if (!context_.untrusted.empty()) {
      refusing.push_back({"self-test", false, context_.untrusted});
    }
    QualityNight tonight;
    tonight.time = point_.time;
    tonight.spreads = measurement_.spreads;
    tonight.levels = measurement_.levels;
    tonight.is_fresh_start = history_.is_fresh_for_quality;
    if (!history_.qualities.empty()) {
      tonight.time =
          std::max(tonight.time, history_.qualities.back().time + std::chrono::seconds(1));
    }
    PANELCAL_TRY(QualityVerdict verdict,
                 judge_qualities(history_.qualities, tonight, context_.nightly));
    step_.qualities = std::move(verdict.qualities);
    step_.alarms = std::move(verdict.alarms);
    std::ranges::move(verdict.gates, std::back_inserter(refusing));
    return {};
  }

  /// The entry and its companion, both or none.
  Expected<void> record(LedgerDraft draft, const CalibrationResult* measurement) {
    LedgerRecord& record = draft.record;
    const bool installs = step_.state == NightState::Installed;
    record.verdict = installs ? LedgerVerdict::Installed : LedgerVerdict::Refused;
    record.reason = installs ? "all gates passed" : step_.summary.substr(0, kMaxLedgerTextBytes);
    record.asked_by = words_.asked_by;
    record.software = words_.software;
    record.temperature_degC = words_.temperature_degC;
    // If another one was installed since, tonight was judged against the wrong one.
    if (installs && history_.in_force) record.replaces = history_.in_force->id;
    if (measurement != nullptr && calibration_.has_file()) {
      PANELCAL_CHECK(note_head(*ledger_, draft));
    }
    PANELCAL_TRY(const int used_up, calibration_.used_up());
    LedgerDraft companion =
        companion_draft(record, context_.night, measurement, used_up, step_.state, step_.summary);
    const std::array<LedgerDraft, 2> drafts = {std::move(draft), std::move(companion)};
    PANELCAL_TRY(const std::vector<LedgerEntry> entries, ledger_->append_all(drafts));
    step_.ledger_id = entries.front().id;
    if (!installs) return {};
    step_.in_force_id = entries.front().id;
    in_force_ = measurement->result.point.value;
    const Expected<bool> written = calibration_.install(*ledger_);
    if (written) return {};
    Diagnostic problem = written.error();
    problem.what = fmt::format(
        "entry {} is in force and its file is not written: {}", *step_.ledger_id, problem.what);
    return failure(std::move(problem));
  }

  Expected<void> finish() {
    say(context_, title() + ": " + step_.summary);
    return fill_outlook(history_, {point_, false}, in_force_, context_.nightly, step_);
  }

  const NightContext& context_;
  Calibration& calibration_;
  Ledger* ledger_;
  NightStep step_;
  NightHistory history_;
  RecordWords words_;
  CalibrationResult measurement_;
  std::optional<Eigen::VectorXd> in_force_;
  DriftPoint point_;
};

}  // namespace

NightStep run_night_step(const NightContext& context, Calibration& calibration, Ledger& ledger) {
  return Step(context, calibration, &ledger).run();
}

NightStep foresee_night_step(const NightContext& context,
                             Calibration& calibration,
                             Ledger* ledger) {
  return Step(context, calibration, ledger).foresee();
}

NightStep unreached_night_step(const Calibration& calibration, const std::string& why) {
  NightStep step = begin_step(calibration);
  step.state = NightState::NotReached;
  step.summary = "not begun: " + why;
  return step;
}

NightStep held_night_step(const Calibration& calibration, const std::string& why) {
  NightStep step = unreached_night_step(calibration, why);
  step.state = NightState::Held;
  return step;
}

}  // namespace panelcal
