// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/screen.h"

#include <algorithm>
#include <array>

#include "calib/base/json/facts.h"

namespace panelcal::internal {
namespace {

using facts::Json;

constexpr int kScreenVersion = 1;
constexpr std::array<std::string_view, 8> kStateNames = {
    "checked", "measuring", "asking", "done", "held", "failed", "stopped", "resumable"};

Json points(const std::vector<Eigen::Vector2d>& all) {
  Json out = Json::array();
  for (const Eigen::Vector2d& one : all) out.push_back(facts::point(one));
  return out;
}

/// Leaves the key out where there is nothing to state.
void put(Json& out, const char* key, const std::optional<Eigen::Vector2d>& value) {
  if (value) out[key] = facts::point(*value);
}
void put(Json& out, const char* key, const std::string& value) {
  if (!value.empty()) out[key] = value;
}

Json finding_json(const Diagnostic& finding) {
  const CodeInfo& code = info(finding.code);
  Json out;
  out["severity"] = code.severity == Severity::Error ? "error" : "warning";
  out["code"] = code.slug;
  put(out, "file", finding.place.file);
  if (finding.place.line > 0) out["line"] = finding.place.line;
  if (finding.place.column > 0) out["column"] = finding.place.column;
  out["what"] = finding.message();
  put(out, "expected", finding.expected);
  return out;
}

Json screen_target_json(const ScreenTarget& target) {
  Json out;
  out["seq"] = target.seq;
  out["line"] = target.line;
  out["command"] = target.command;
  out["tool"] = target.tool;
  out["path"] = target.path;
  out["nominal_mm"] = facts::point(target.nominal_mm);
  out["expected_mm"] = facts::point(target.expected_mm);
  out["status"] = target.status;
  put(out, "measured_mm", target.measured_mm);
  put(out, "sigma_um", target.sigma_um);
  put(out, "residual_um", target.residual_um);
  put(out, "reason", target.reason);
  put(out, "by", target.by);
  put(out, "who", target.who);
  put(out, "when", target.when);
  out["has_picture"] = target.has_picture;
  return out;
}

Json series_json(const ScreenSeries& series) {
  Json out;
  out["line"] = series.line;
  out["path"] = series.path;
  out["n_targets"] = series.n_targets;
  out["is_fitted"] = series.is_fitted;
  out["is_accepted"] = series.is_accepted;
  put(out, "words", series.words);
  return out;
}

Json question_json(const ScreenQuestion& question) {
  Json out;
  out["id"] = question.id;
  if (question.seq) out["seq"] = *question.seq;
  out["reason"] = question.reason;
  Json& candidates = out["candidates"] = Json::array();
  for (const ScreenCandidate& candidate : question.candidates) {
    candidates.push_back({{"at_px", facts::point(candidate.at_px)},
                          {"size_px", facts::number(candidate.size_px)},
                          {"score", facts::number(candidate.score)}});
  }
  out["choices"] = question.choices;
  Json& why_not = out["why_not"] = Json::object();
  for (const auto& [choice, why] : question.why_not) why_not[choice] = why;
  if (!question.why_no_jog.empty()) {
    why_not["jog"] = question.why_no_jog;
  } else if (question.seq) {
    out["jog_mm"] = facts::number(question.jog_limit_mm);
  }
  if (question.exposure_us) out["exposure_us"] = facts::number(*question.exposure_us);
  return out;
}

void put_results(const ScreenJob& job, Json& out) {
  if (job.question) out["question"] = question_json(*job.question);
  if (job.again) out["again"] = {{"seqs", job.again->seqs}, {"words", job.again->words}};
  if (job.verdict) {
    out["verdict"] = {{"may_drill", job.verdict->may_drill}, {"words", job.verdict->words}};
  }
  out["has_report"] = job.has_report;
  out["has_facts"] = job.has_facts;
  out["outputs"] = job.outputs;
  if (job.n_holes) out["n_holes"] = *job.n_holes;
}

Json job_json(const ScreenJob& job) {
  Json out;
  out["id"] = job.id;
  out["program"] = job.program;
  out["output_format"] = job.output_format;
  out["state"] = name(job.state);
  Json& findings = out["findings"] = Json::array();
  for (const Diagnostic& finding : job.findings) findings.push_back(finding_json(finding));
  Json& targets = out["targets"] = Json::array();
  for (const ScreenTarget& target : job.targets) targets.push_back(screen_target_json(target));
  Json& series = out["series"] = Json::array();
  for (const ScreenSeries& one : job.series) series.push_back(series_json(one));
  put_results(job, out);
  return out;
}

Json view_json(const ScreenView& view, std::uint64_t frame) {
  Json out;
  out["frame"] = frame;
  out["width_px"] = view.width_px;
  out["height_px"] = view.height_px;
  out["um_per_px"] = facts::number(view.um_per_px);
  out["place_mm"] = facts::point(view.place_mm);
  if (view.search_px) {
    Json& search = out["search"];
    search["at_px"] = facts::point(*view.search_px);
    if (view.search_radius_px) search["radius_px"] = facts::number(*view.search_radius_px);
  }
  if (!view.outline_px.empty()) out["outline_px"] = points(view.outline_px);
  if (view.ellipse) {
    out["ellipse"] = {{"at_px", facts::point(view.ellipse->at_px)},
                      {"axes_px", facts::point(view.ellipse->axes_px)},
                      {"angle_rad", facts::number(view.ellipse->angle_rad)}};
  }
  if (view.lamp) out["lamp"] = facts::number(*view.lamp);
  if (view.contrast) out["contrast"] = facts::number(*view.contrast);
  if (view.sharpness) out["sharpness"] = facts::number(*view.sharpness);
  return out;
}

Json calibration_json(const ScreenCalibration& calibration) {
  Json out;
  out["kind"] = calibration.kind;
  out["state"] = calibration.state;
  out["lines"] = calibration.lines;
  put(out, "verdict", calibration.verdict);
  out["has_page"] = calibration.has_page;
  return out;
}

Json history_json(const std::vector<ScreenHistory>& history) {
  Json out = Json::array();
  for (const ScreenHistory& one : history) {
    Json entry;
    entry["kind"] = one.kind;
    entry["entry"] = one.entry;
    entry["when"] = one.when;
    entry["in_force"] = one.in_force;
    put(entry, "words", one.words);
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace

std::string_view name(JobState state) {
  return kStateNames[static_cast<std::size_t>(state)];
}

std::optional<JobState> job_state_from_name(std::string_view name) {
  const auto found = std::ranges::find(kStateNames, name);
  if (found == kStateNames.end()) return std::nullopt;
  return static_cast<JobState>(found - kStateNames.begin());
}

std::string to_json(const Screen& screen) {
  Json out = facts::envelope("screen", kScreenVersion);
  out["machine"] = screen.machine;
  out["source"] = screen.source;
  Json& programs = out["programs"] = Json::array();
  for (const ScreenProgram& program : screen.programs) {
    programs.push_back({{"name", program.name}, {"size_bytes", program.size_bytes}});
  }
  if (screen.job) out["job"] = job_json(*screen.job);
  if (screen.view) out["view"] = view_json(*screen.view, screen.frame);
  if (screen.calibration) out["calibration"] = calibration_json(*screen.calibration);
  out["kinds"] = screen.kinds;
  out["history"] = history_json(screen.history);
  return facts::text(out);
}

}  // namespace panelcal::internal
