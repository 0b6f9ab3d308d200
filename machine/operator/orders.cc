// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/orders.h"

#include <algorithm>
#include <filesystem>

#include "machine/job/output/output_format.h"
#include "machine/operator/programs.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

void begin(ScreenJob& job) {
  job.state = JobState::Measuring;
  job.question.reset();
  job.again.reset();
  job.verdict.reset();
}

/// A pixel of the picture that the person saw.
Expected<void> check_pixel(const Screen& screen, const Answer& answer) {
  const ScreenQuestion& question = *screen.job->question;
  if (question.is_jogging || (answer.frame && *answer.frame < question.first_frame)) {
    return failure(
        refused("the picture is from before the movement", "a pixel of the new picture"));
  }
  const Eigen::Vector2d& at_px = *answer.at_px;
  const bool is_inside = screen.view && at_px.minCoeff() >= -0.5 &&
                         at_px.x() <= screen.view->width_px - 0.5 &&
                         at_px.y() <= screen.view->height_px - 0.5;
  if (is_inside) return {};
  return failure(
      refused(fmt::format("pixel ({}, {})", at_px.x(), at_px.y()), "a pixel of the picture shown"));
}

/// A light that this question offers, if one is asked for.
Expected<void> check_offered_light(const ScreenQuestion& question,
                                   const std::optional<double>& value,
                                   const std::string& name) {
  const auto why_not = question.why_not.find(name);
  if (!value || why_not == question.why_not.end()) return {};
  return failure(refused(name + ": " + why_not->second, "an answer without it"));
}

Expected<void> check_choice(const Screen& screen, const Answer& answer) {
  const ScreenQuestion& question = *screen.job->question;
  const std::string choice(name(answer.choice));
  if (std::ranges::find(question.choices, choice) == question.choices.end()) {
    const auto why = question.why_not.find(choice);
    return failure(refused(
        "choice " + quoted(choice) + (why == question.why_not.end() ? "" : ": " + why->second),
        fmt::format("{}", fmt::join(question.choices, ", "))));
  }
  if (answer.index && *answer.index >= question.candidates.size()) {
    return failure(refused(fmt::format("candidate {}", *answer.index),
                           fmt::format("below {}", question.candidates.size())));
  }
  PANELCAL_CHECK(check_offered_light(question, answer.lamp, "lamp"));
  PANELCAL_CHECK(check_offered_light(question, answer.exposure_us, "exposure"));
  if (answer.at_px) return check_pixel(screen, answer);
  return {};
}

}  // namespace

Expected<void> check_idle(const Screen& screen) {
  if (screen.job && is_running(screen.job->state)) {
    return failure(refused("a job is running", "stop, or the end of the job"));
  }
  if (screen.calibration && screen.calibration->state == "running") {
    return failure(refused("a calibration is running", "its end"));
  }
  return {};
}

Expected<void> check_open(const Screen& screen) {
  PANELCAL_CHECK(check_idle(screen));
  if (!screen.job || screen.job->state != JobState::Resumable) return {};
  return failure(refused("job " + screen.job->id + " was interrupted", "resume, or close before"));
}

Expected<void> take_close(Screen& screen) {
  if (!screen.job) return failure(refused("no job is open", "open"));
  if (is_running(screen.job->state))
    return failure(refused("a job is running", "stop before close"));
  screen.job.reset();
  return {};
}

Expected<void> take_start(Screen& screen) {
  PANELCAL_CHECK(check_idle(screen));
  if (!screen.job || screen.job->state != JobState::Checked) {
    return failure(refused("no program is checked", "open"));
  }
  const auto is_error = [](const Diagnostic& d) { return d.severity() == Severity::Error; };
  const auto error = std::ranges::find_if(screen.job->findings, is_error);
  if (error != screen.job->findings.end()) {
    return failure(refused("the check has found an error: " + error->text(), "a mended program"));
  }
  begin(*screen.job);
  return {};
}

Expected<void> take_resume(Screen& screen) {
  PANELCAL_CHECK(check_idle(screen));
  const bool may_resume = screen.job && (screen.job->state == JobState::Resumable ||
                                         screen.job->state == JobState::Stopped ||
                                         screen.job->state == JobState::Failed);
  if (!may_resume) return failure(refused("no job was interrupted", "start"));
  begin(*screen.job);
  return {};
}

Expected<void> take_stop(Screen& screen) {
  if (screen.calibration && screen.calibration->state == "running") return {};
  if (!screen.job || !is_running(screen.job->state)) {
    return failure(refused("no job is running", "start"));
  }
  screen.job->question.reset();
  screen.job->state = JobState::Measuring;
  return {};
}

Expected<void> take_answer(Screen& screen, const Answer& answer) {
  if (!screen.job || !screen.job->question) {
    return failure(refused("no question is open", "an answer to the question that is shown"));
  }
  ScreenJob& job = *screen.job;
  if (answer.question != job.question->id) {
    return failure(refused(fmt::format("question {} is not open", answer.question),
                           fmt::format("question {}", job.question->id)));
  }
  PANELCAL_CHECK(check_choice(screen, answer));
  const auto seq = static_cast<std::size_t>(job.question->seq.value_or(-1));
  if (seq < job.targets.size()) job.targets[seq].status = "looking";
  job.question.reset();
  job.state = JobState::Measuring;
  return {};
}

Expected<void> take_jog(Screen& screen, const Eigen::Vector2d& by_mm) {
  if (!screen.job || !screen.job->question || !screen.job->question->seq) {
    return failure(refused("no question is open", "a jog while a target is asked about"));
  }
  ScreenQuestion& question = *screen.job->question;
  if (!question.why_no_jog.empty()) return failure(refused(question.why_no_jog, "no jog"));
  const Eigen::Vector2d jogged_mm = question.jogged_mm + by_mm;
  if (!(jogged_mm.norm() <= question.jog_limit_mm)) {
    return failure(refused(fmt::format("{:.3f} mm from the first picture", jogged_mm.norm()),
                           fmt::format("at most {:.3f} mm", question.jog_limit_mm)));
  }
  question.jogged_mm = jogged_mm;
  question.is_jogging = true;
  return {};
}

Expected<void> check_write(const Screen& screen, const std::string& name) {
  const bool may_write = screen.job && screen.job->state == JobState::Done && screen.job->verdict &&
                         screen.job->verdict->may_drill;
  if (!may_write) return failure(refused("no job may be drilled", "a job that is done"));
  PANELCAL_CHECK(check_name(name));
  const auto format = output_format_of_extension(std::filesystem::path(name).extension().string());
  if (format && panelcal::name(*format) == screen.job->output_format) return {};
  return failure(refused("name " + quoted(name),
                         screen.job->output_format == "excellon" ? ".drl or .exc" : ".s5 or .sm"));
}

}  // namespace panelcal::internal
