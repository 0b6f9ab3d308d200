// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/operator_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/look/vision_procedure.h"
#include "program/walk/measuring/series_examination.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// At most ten pictures a second.
constexpr std::chrono::milliseconds kPictureInterval{100};
constexpr std::chrono::milliseconds kIdleInterval{60'000};
/// No person points better at a pixel.
constexpr double kHandSigma_px = 0.5;

std::string choice_words(const MeasurementRequest& request,
                         const Answer& answer,
                         const Measurement& measured) {
  std::string what;
  switch (answer.choice) {
    case Choice::Again:
      what = "looked at again";
      if (answer.lamp) what += fmt::format(", lamp {}", *answer.lamp);
      if (answer.exposure_us) what += fmt::format(", exposure {} us", *answer.exposure_us);
      break;
    case Choice::Search:
      what = fmt::format(
          "searched for at pixel ({:.1f}, {:.1f})", answer.at_px->x(), answer.at_px->y());
      break;
    case Choice::Candidate:
      what = fmt::format("candidate {} taken", *answer.index + 1);
      break;
    case Choice::Hand:
      what = fmt::format(
          "placed by hand at pixel ({:.1f}, {:.1f})", answer.at_px->x(), answer.at_px->y());
      break;
    case Choice::LeaveBoardOut:
      what = "its board left out";
      break;
    case Choice::Keep:
      what = "kept though its series contradicts it";
      break;
    default:
      what = "skipped";
  }
  return fmt::format("{}: {} ({})", describe(request), what, name(measured.status));
}

}  // namespace

Diagnostic stopped() {
  return {Code::Interrupted, {"panelcal serve", 0, 0}, "the job was stopped", ""};
}

void show_measured(const Measurement& measurement, ScreenTarget& target) {
  target.status = name(measurement.status);
  target.reason = measurement.reason;
  target.expected_mm = measurement.request.expected.in_mm();
  target.measured_mm.reset();
  target.sigma_um.reset();
  if (measurement.status == MeasurementStatus::Found) {
    target.measured_mm = measurement.measured.position.in_mm();
    target.sigma_um = 1e3 * measurement.measured.cov.diagonal().cwiseSqrt();
  }
  const Decision& decision = measurement.decision;
  const bool is_found = measurement.status == MeasurementStatus::Found;
  target.by = decision.is_by_person() ? name(decision.by) : is_found ? "camera" : "";
  target.who = decision.who;
  target.when = decision.when;
}

OperatorSource::OperatorSource(const Station& station,
                               std::shared_ptr<MeasurementSource> source,
                               ViewTaker* eye,
                               std::map<std::int64_t, Measurement> counted)
    : at_(station), source_(std::move(source)), eye_(eye), counted_(std::move(counted)) {
}

Expected<void> OperatorSource::check_stop() const {
  if (at_.desk.must_stop()) return failure(stopped());
  return {};
}

Expected<std::optional<FocusResult>> OperatorSource::focus(const MeasurementRequest& request) {
  PANELCAL_CHECK(check_stop());
  return source_->focus(request);
}

Expected<std::optional<CalibrationAnswer>> OperatorSource::calibrate(
    const CalibrationOrder& order) {
  PANELCAL_CHECK(check_stop());
  return source_->calibrate(order);
}

const Measurement* OperatorSource::counted(const MeasurementRequest& request) const {
  const auto found = counted_.find(request.seq);
  if (found == counted_.end()) return nullptr;
  const MeasurementRequest& recorded = found->second.request;
  const bool is_same = recorded.line == request.line && recorded.command == request.command &&
                       recorded.path == request.path &&
                       recorded.file_sha256 == request.file_sha256 &&
                       recorded.nominal == request.nominal && recorded.expected == request.expected;
  return is_same ? &found->second : nullptr;
}

void OperatorSource::show_looking(const MeasurementRequest& request) {
  at_.desk.change([&](Screen& screen) {
    const auto i = static_cast<std::size_t>(request.seq);
    screen.job->targets.resize(std::max(screen.job->targets.size(), i + 1));
    ScreenTarget& target = screen.job->targets[i];
    target.seq = request.seq;
    target.expected_mm = request.expected.in_mm();
    target.status = "looking";
  });
}

void OperatorSource::show(const Measurement& measurement) {
  // A picture that cannot be kept is missing, and measures all the same.
  const std::string& jpeg = at_.feed.jpeg();
  const auto& shown = at_.feed.shown();
  const bool is_seen = shown && shown->request.seq == measurement.request.seq && !jpeg.empty();
  const auto file = at_.folder.file(picture_name(measurement.request.seq));
  const bool has_picture = is_seen && write_file(file, jpeg).has_value();
  at_.desk.change([&](Screen& screen) {
    ScreenTarget& target = screen.job->targets[static_cast<std::size_t>(measurement.request.seq)];
    show_measured(measurement, target);
    target.has_picture |= has_picture;
  });
}

Expected<Measurement> OperatorSource::measure(const MeasurementRequest& request) {
  PANELCAL_CHECK(check_stop());
  show_looking(request);
  if (const Measurement* const held = counted(request)) {
    Measurement answer = *held;
    answer.request = request;
    note_left_out(answer);
    show(answer);
    return answer;
  }
  if (request.is_of_left_out_board || left_out_.contains(static_cast<std::size_t>(request.seq))) {
    Measurement answer = board_answer_;
    answer.request = request;
    PANELCAL_CHECK(at_.folder.append(answer));
    show(answer);
    return answer;
  }
  PANELCAL_TRY(Measurement measurement, source_->measure(request));
  if (measurement.status != MeasurementStatus::Found) {
    PANELCAL_TRY(std::optional<Measurement> decided,
                 ask(request, std::move(measurement), Cause::NotFound));
    measurement = *std::move(decided);
  }
  measurement.measured.cov(1, 0) = measurement.measured.cov(0, 1);
  PANELCAL_CHECK(at_.folder.append(measurement));
  show(measurement);
  return measurement;
}

Expected<std::optional<Measurement>> OperatorSource::reconsider(
    const Contradiction& contradiction) {
  Measurement doubted = contradiction.worst;
  doubted.status = MeasurementStatus::Rejected;
  doubted.reason = contradiction.reason;
  // The series has chosen among its candidates already.
  doubted.candidates.clear();
  const MeasurementRequest request = doubted.request;
  PANELCAL_TRY(std::optional<Measurement> decided,
               ask(request, std::move(doubted), Cause::Contradicted));
  if (!decided) {
    show(contradiction.worst);
    return std::nullopt;
  }
  decided->measured.cov(1, 0) = decided->measured.cov(0, 1);
  PANELCAL_CHECK(at_.folder.replace(*decided));
  show(*decided);
  return decided;
}

void OperatorSource::note_left_out(const Measurement& answer) {
  const auto seq = static_cast<std::size_t>(answer.request.seq);
  if (answer.status == MeasurementStatus::Skipped) skipped_.push_back(seq);
  if (answer.status != MeasurementStatus::BoardLeftOut) return;
  if (const SeriesResult* const series = series_of(seq)) {
    left_out_.insert(series->measurements.begin(), series->measurements.end());
  }
  board_answer_ = answer;
  board_answer_.reason = "board left out by " + answer.decision.who;
}

// --- questions ---------------------------------------------------------------------------------

Expected<std::optional<Measurement>> OperatorSource::ask(const MeasurementRequest& request,
                                                         Measurement lost,
                                                         Cause cause) {
  while (true) {
    ScreenQuestion question = question_about(request, lost, cause);
    at_.desk.change([&](Screen& screen) {
      ScreenJob& job = *screen.job;
      job.state = JobState::Asking;
      question.first_frame = screen.frame;
      job.question = std::move(question);
      show_measured(lost, job.targets[static_cast<std::size_t>(request.seq)]);
    });
    PANELCAL_TRY(const Answer answer, wait_for_answer(request));
    const std::string when = iso_8601(at_.clock());
    if (answer.choice == Choice::Keep) {
      PANELCAL_CHECK(at_.folder.append(
          JobChoice{request.seq, choice_words(request, answer, lost), answer.who, when}));
      return std::nullopt;
    }
    Expected<Measurement> decided = decide(request, lost, answer);
    if (!decided) {
      PANELCAL_CHECK(check_stop());
      // The machine is as it was: the person may choose otherwise.
      lost.reason = decided.error().message();
      continue;
    }
    decided->request = request;
    decided->decision.who = answer.who;
    decided->decision.when = when;
    PANELCAL_CHECK(at_.folder.append(
        JobChoice{request.seq, choice_words(request, answer, *decided), answer.who, when}));
    note_left_out(*decided);
    const bool holds = decided->status == MeasurementStatus::Found || is_left_out(*decided);
    if (holds) return *std::move(decided);
    lost = *std::move(decided);
  }
}

ScreenQuestion OperatorSource::question_about(const MeasurementRequest& request,
                                              const Measurement& lost,
                                              Cause cause) {
  ScreenQuestion question;
  question.id = ++at_.n_questions;
  question.seq = request.seq;
  question.reason = lost.reason;
  question.choices = {"again"};
  offer_places(request, question);
  offer_candidates(lost, question);
  const auto offer = [&](Choice choice, const std::string& why_not) {
    if (why_not.empty()) question.choices.emplace_back(name(choice));
    if (!why_not.empty()) question.why_not.emplace(name(choice), why_not);
  };
  offer(Choice::Skip, why_not_skip(request));
  offer(Choice::LeaveBoardOut, why_not_leave_board_out(request));
  if (cause == Cause::Contradicted) question.choices.emplace_back(name(Choice::Keep));
  note_settings(question);
  question.choices.emplace_back("stop");
  return question;
}

/// The choices that need the picture's pixels to have a place.
void OperatorSource::offer_places(const MeasurementRequest& request,
                                  ScreenQuestion& question) const {
  const auto& shown = at_.feed.shown();
  const bool is_seen = shown && shown->request.seq == request.seq;
  std::string why_not;
  if (!is_seen) why_not = "there is no picture of it";
  if (is_seen && request.settings.delta) why_not = "the target is four marks about its place";
  const auto offer = [&](Choice choice, const std::string& why) {
    if (why.empty()) {
      question.choices.emplace_back(name(choice));
    } else {
      question.why_not.emplace(name(choice), why);
    }
  };
  offer(Choice::Search, why_not);
  if (why_not.empty() && !at_.nominal.calibrations.empty()) {
    why_not = "the program calibrates the camera's offset, whose error a place by hand cannot know";
  }
  offer(Choice::Hand, why_not);
  question.jog_limit_mm = jog_limit_mm(at_.machine.vision);
  if (!at_.may_jog || eye_ == nullptr) question.why_no_jog = "recorded pictures do not move";
  if (!is_seen) question.why_no_jog = "there is no picture of the target";
}

void OperatorSource::offer_candidates(const Measurement& lost, ScreenQuestion& question) {
  offered_.clear();
  const auto& shown = at_.feed.shown();
  const bool has_places =
      std::ranges::find(question.choices, name(Choice::Hand)) != question.choices.end();
  for (std::size_t i = 0; has_places && i < lost.candidates.size(); ++i) {
    const MeasuredCandidate& candidate = lost.candidates[i];
    const auto at_px = shown->pixel_of(candidate.place.position);
    if (!at_px) continue;
    ScreenCandidate offered{*at_px, 0, candidate.score};
    const auto distance_px = [&](const ScreenCandidate& one) {
      return (one.at_px - *at_px).norm();
    };
    const auto nearest = std::ranges::min_element(shown->candidates, {}, distance_px);
    if (nearest != shown->candidates.end()) offered.size_px = nearest->size_px;
    question.candidates.push_back(offered);
    offered_.push_back(i);
  }
  if (!offered_.empty()) {
    question.choices.emplace_back(name(Choice::Candidate));
  } else {
    question.why_not.emplace(name(Choice::Candidate), "the picture has no candidate");
  }
}

std::string OperatorSource::why_not_skip(const MeasurementRequest& request) const {
  const auto seq = static_cast<std::size_t>(request.seq);
  const SeriesResult* const series = series_of(seq);
  if (!at_.may_skip) return "this language has no series that does without one of its targets";
  if (series == nullptr) return "the hole is drilled where this target is";
  std::vector<std::size_t> left_out = skipped_;
  left_out.push_back(seq);
  if (is_checked_without(*series, at_.nominal, left_out)) return "";
  const auto n_left_out = std::ranges::count_if(left_out, [&](std::size_t i) {
    return std::ranges::find(series->measurements, i) != series->measurements.end();
  });
  return fmt::format(
      "{} of {} targets would be left, which the model \"{}\" follows wherever they "
      "are: no gate could notice a wrong one",
      static_cast<std::ptrdiff_t>(series->measurements.size()) - n_left_out,
      series->measurements.size(),
      name(series->prescribed));
}

std::string OperatorSource::why_not_leave_board_out(const MeasurementRequest& request) const {
  const auto seq = static_cast<std::size_t>(request.seq);
  const SeriesResult* const series = series_of(seq);
  if (!at_.may_skip || !at_.why_not_leave_out) return "this language has no boards that end";
  if (series == nullptr) return "the hole is drilled where this target is";
  if (request.path.empty()) return "the target is of no copy of a pattern, but of the whole panel";
  std::set<std::size_t> left_out = left_out_;
  left_out.insert(series->measurements.begin(), series->measurements.end());
  return at_.why_not_leave_out(left_out);
}

const SeriesResult* OperatorSource::series_of(std::size_t seq) const {
  const auto holds = [&](const SeriesResult& series) {
    return std::ranges::find(series.measurements, seq) != series.measurements.end();
  };
  const auto series = std::ranges::find_if(at_.nominal.series, holds);
  return series == at_.nominal.series.end() ? nullptr : &*series;
}

void OperatorSource::note_settings(ScreenQuestion& question) const {
  if (eye_ != nullptr) question.exposure_us = eye_->exposure_us();
  if (eye_ == nullptr || !eye_->can_set(CameraSetting::Lamp)) {
    question.why_not.emplace("lamp", "this source has no lamp to set");
  }
  if (eye_ == nullptr || !eye_->can_set(CameraSetting::Exposure)) {
    question.why_not.emplace("exposure",
                             "this camera's exposure is automatic, or set by its address alone");
  } else if (!question.exposure_us) {
    question.why_not.emplace("exposure",
                             "this camera does not tell its exposure, which could not be put back");
  }
}

Expected<Answer> OperatorSource::wait_for_answer(const MeasurementRequest& request) {
  while (true) {
    const bool is_live = at_.is_live && eye_ != nullptr && at_.desk.is_watched();
    const Desk::Word word = at_.desk.wait_for_word(is_live ? kPictureInterval : kIdleInterval);
    if (word.must_stop) return failure(stopped());
    if (word.answer) return *word.answer;
    const auto& shown = at_.feed.shown();
    const bool is_seen = shown && shown->request.seq == request.seq;
    if (word.jog_mm) {
      jog(request, *word.jog_mm);
    } else if (is_live && is_seen) {
      look_live(request, View(shown->view));
    }
  }
}

void OperatorSource::jog(const MeasurementRequest& request, const Eigen::Vector2d& by_mm) {
  const auto& shown = at_.feed.shown();
  if (!shown || eye_ == nullptr) return;
  View view = shown->view;
  view.axis = view.axis + displacement_mm<frame::Machine>(by_mm);
  look_live(request, view);
  at_.desk.change([](Screen& screen) {
    if (!screen.job->question) return;
    screen.job->question->is_jogging = false;
    screen.job->question->first_frame = screen.frame;
  });
}

/// What fails here is told by the question's reason; the person may try otherwise.
void OperatorSource::look_live(const MeasurementRequest& request, const View& view) {
  const ZoomedCamera camera = at_.feed.shown()->camera;
  const Expected<TakenPicture> picture = eye_->take(request, view);
  if (picture) return at_.feed.show(request, view, *picture, camera);
  at_.desk.change([&](Screen& screen) {
    if (screen.job->question) screen.job->question->reason = picture.error().message();
  });
}

// --- answers -----------------------------------------------------------------------------------

Expected<Measurement> OperatorSource::decide(const MeasurementRequest& request,
                                             const Measurement& lost,
                                             const Answer& answer) {
  switch (answer.choice) {
    case Choice::Again:
      return look_again(request, answer);
    case Choice::Search:
      return search(request, answer);
    case Choice::Candidate:
      return take_candidate(lost, offered_[*answer.index]);
    case Choice::Hand:
      return place_by_hand(*answer.at_px);
    case Choice::Skip: {
      Measurement out;
      out.status = MeasurementStatus::Skipped;
      out.reason = "skipped by " + answer.who + (lost.reason.empty() ? "" : "; " + lost.reason);
      out.decision.by = Decider::Skip;
      return out;
    }
    case Choice::LeaveBoardOut: {
      Measurement out;
      out.status = MeasurementStatus::BoardLeftOut;
      out.reason =
          "board left out by " + answer.who + (lost.reason.empty() ? "" : "; " + lost.reason);
      out.decision.by = Decider::LeaveBoardOut;
      return out;
    }
    case Choice::Keep:
    case Choice::Done:
    case Choice::Stop:
      break;
  }
  return failure(stopped());
}

Expected<Measurement> OperatorSource::look_again(MeasurementRequest request, const Answer& answer) {
  if (answer.lamp) request.settings.lamp = answer.lamp;
  request.settings.exposure_us = answer.exposure_us;
  PANELCAL_TRY(Measurement out, source_->measure(request));
  out.decision.by = Decider::Camera;
  return out;
}

/// The target is where the person points, as far as the search radius is right.
Expected<Measurement> OperatorSource::search(const MeasurementRequest& request,
                                             const Answer& answer) {
  MeasurementRequest moved = request;
  moved.expected = at_.feed.shown()->place_of(*answer.at_px, kHandSigma_px).position;
  PANELCAL_TRY(Measurement out, source_->measure(moved));
  // Other places than the request's were searched: where no candidate is says nothing.
  out.listed.reset();
  out.decision.by = Decider::Camera;
  return out;
}

/// The series is not to choose another one.
Measurement OperatorSource::take_candidate(const Measurement& lost, std::size_t index) const {
  const MeasuredCandidate& candidate = lost.candidates[index];
  Measurement out;
  out.status = MeasurementStatus::Found;
  out.measured = candidate.place;
  out.score = candidate.score;
  if (!candidate.by_camera.isZero(0)) out.by_camera = candidate.by_camera;
  out.image = lost.image;
  out.decision.by = Decider::Candidate;
  return out;
}

/// The picture's part of the uncertainty; the machine's is added to every target alike.
Measurement OperatorSource::place_by_hand(const Eigen::Vector2d& at_px) const {
  const ShownPicture& shown = *at_.feed.shown();
  Measurement out;
  out.status = MeasurementStatus::Found;
  out.measured = shown.place_of(at_px, kHandSigma_px);
  out.by_camera = shown.by_camera(at_px);
  out.image = shown.name;
  out.decision.by = Decider::Hand;
  return out;
}

}  // namespace panelcal::internal
