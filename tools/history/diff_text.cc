// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tools/figures/text.h"
#include "tools/history/diff.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal::history {
namespace {

using report::counted;
using report::fixed;
using report::fixed_signed;

std::string diff_json_string(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// To a picometre: smaller parts are rounding, and differ from processor to processor.
double rounded_to_nm(double value_mm) {
  const double rounded_mm = std::round(value_mm * 1e9) / 1e9;
  return rounded_mm + 0.0;
}

std::string diff_json_string(const Eigen::Vector2d& v_mm) {
  return fmt::format("[{},{}]", rounded_to_nm(v_mm.x()), rounded_to_nm(v_mm.y()));
}

std::string um_text(const Displacement<frame::Actual>& shift) {
  return fmt::format("({}, {}) um",
                     fixed_signed(shift.in_mm().x() * 1e3, 2),
                     fixed_signed(shift.in_mm().y() * 1e3, 2));
}

std::string um_text(Length length) {
  return fixed(length.in_um(), 2) + " um";
}

std::string where(const plan::PlannedPlace& place) {
  std::string text = report::point_text(place.nominal.in_mm()) + " mm, ";
  if (!place.file.empty()) text += report::escaped(place.file) + " ";
  text += fmt::format("line {}", place.line);
  const std::string path = report::path_text(place.path);
  return path.empty() ? text : text + " " + path;
}

}  // namespace

std::string job_shift_text(const JobShift& shift, const JobShiftFacts& facts) {
  const HoleShiftSummary& s = shift.summary;
  const auto n = static_cast<std::int64_t>(s.n_holes);
  const auto n_drilled = static_cast<std::int64_t>(shift.n_drilled);
  std::string text =
      fmt::format("\n{}: {}", escaped_controls(facts.program_file), counted(n_drilled, "hole"));
  if (n > n_drilled) {
    text += ", " + counted(n - n_drilled, shift.has_routs ? "end" : "slot end") +
            (shift.has_routs ? " of slots and rout moves" : "; rout moves are left out");
  }
  text += ", " + counted(static_cast<std::int64_t>(shift.targets.size()), "target") + "\n";
  if (s.max.in_um() == 0) {
    text += "no place moves\n";
  } else if (shift.is_uniform()) {
    text += fmt::format("all move alike, by {}: {}\n", um_text(s.mean_shift), um_text(s.max));
  } else {
    text += fmt::format("largest shift {} at {}: {}\n",
                        um_text(s.max),
                        where(shift.worst.place),
                        um_text(shift.worst.shift));
    text += fmt::format("95 % move by no more than {}; rms {}, mean {}\n",
                        um_text(s.p95),
                        um_text(s.rms),
                        um_text(s.mean));
    text += "the mean shift is " + um_text(s.mean_shift) + "\n";
  }
  if (shift.n_still > 0) {
    text += "no target corrects, and so nothing moves, " +
            counted(static_cast<std::int64_t>(shift.n_still), "place") + "\n";
  }
  for (const std::string& note : facts.notes) text += "note: " + note + "\n";
  return text;
}

std::string job_shift_json(const JobShift& shift, const JobShiftFacts& facts) {
  const HoleShiftSummary& s = shift.summary;
  std::string text = fmt::format(
      R"({{"program":{},"places":{},"holes":{},"targets":{},"uncorrected":{},"rout_moves_left_out":{},)"
      R"("max_mm":{},"p95_mm":{},"p95_relative_error":{},"rms_mm":{},"mean_mm":{},"mean_shift_mm":{},)"
      R"("worst":{{"nominal":{},"shift_mm":{},"line":{},)",
      diff_json_string(facts.program_file),
      s.n_holes,
      shift.n_drilled,
      shift.targets.size(),
      shift.n_still,
      !shift.has_routs,
      rounded_to_nm(s.max.in_mm()),
      rounded_to_nm(s.p95.in_mm()),
      s.p95_relative_error,
      rounded_to_nm(s.rms.in_mm()),
      rounded_to_nm(s.mean.in_mm()),
      diff_json_string(s.mean_shift.in_mm()),
      diff_json_string(shift.worst.place.nominal.in_mm()),
      diff_json_string(shift.worst.shift.in_mm()),
      shift.worst.place.line);
  if (!shift.worst.place.file.empty()) {
    text += fmt::format(R"("file":{},)", diff_json_string(shift.worst.place.file));
  }
  text += fmt::format(R"("tool":{},"path":[{}]}},"notes":[)",
                      shift.worst.place.tool,
                      fmt::join(shift.worst.place.path, ","));
  for (const std::string& note : facts.notes) {
    if (&note != facts.notes.data()) text += ',';
    text += diff_json_string(note);
  }
  return text + "]}";
}

}  // namespace panelcal::history
