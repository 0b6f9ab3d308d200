// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/place_text.h"
#include "tools/history/diff.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using report::counted;
using report::fixed;
using report::fixed_signed;

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
  if (!place.file.empty()) text += escaped_controls(place.file) + " ";
  text += fmt::format("line {}", place.line);
  const std::string path = report::path_text(place.path);
  return path.empty() ? text : text + " " + path;
}

}  // namespace

std::string job_shift_text(const JobShift& shift, const JobShiftWords& words) {
  const HoleShiftSummary& s = shift.summary;
  const auto n = static_cast<std::int64_t>(s.n_holes);
  const auto n_drilled = static_cast<std::int64_t>(shift.n_drilled);
  std::string text =
      fmt::format("\n{}: {}", escaped_controls(words.program_file), counted(n_drilled, "hole"));
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
  for (const std::string& note : words.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace panelcal::history
