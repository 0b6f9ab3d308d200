// SPDX-License-Identifier: Apache-2.0
#include "program/writers/program_writer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "calib/base/plane_vectors.h"
#include "program/model/placement.h"
#include "program/writers/foreign_settings.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Between planes of several Z axes that one does for.
constexpr Length kSamePlane = um(10);

/// Height of the surface under another Z axis above that under the first, each from its reference
/// if the plane counts from one.
Length rise_of_others(const DepthOfCut& cut) {
  double most_mm = 0;
  for (std::size_t k = 0; cut.surface && k < cut.other_surfaces.size(); ++k) {
    Length rise = cut.other_surfaces[k] - *cut.surface;
    if (cut.reference && k < cut.reference->other_heights.size()) {
      rise = rise - (cut.reference->other_heights[k] - cut.reference->height);
    }
    most_mm = std::max(most_mm, std::abs(rise.in_mm()));
  }
  return mm(most_mm);
}

}  // namespace

ProgramWriter::ProgramWriter(ByteSink& bytes,
                             std::optional<Dialect> dialect,
                             ProgramWriterOptions options)
    : TextWriter(bytes), dialect_(dialect), options_(std::move(options)) {
}

void ProgramWriter::begin(const ProgramInfo& info) {
  info_ = info;
  if (dialect_) digits_ = output_digits(*dialect_, info, options_.resolution);
  write_in_axes(info.axis_version);
  reporter_.emplace(info.file, losses_);
}

void ProgramWriter::write_in_axes(int version) {
  const Eigen::Matrix2d orientation = axis_orientation(version);
  written_from_work_ = orientation.transpose();
  is_mirrored_ = internal::is_mirror(orientation);
}

void ProgramWriter::note_place(const Operation& operation) {
  line_ = operation.line;
  file_ = operation.file.empty() ? std::string_view(info_.file) : operation.file;
}

Place ProgramWriter::place() const {
  return {std::string(file_), line_, 0};
}

/// "... has no form in Excellon CNC-7".
std::string ProgramWriter::without_form(std::string what) const {
  return std::move(what) + " has no form in " + std::string(dialect_ ? name(*dialect_) : "G-code");
}

void ProgramWriter::lose(std::string what) {
  reporter_->set_file(std::string(file_));
  reporter_->report(Code::TranslationLoss, line_, 0, without_form(std::move(what)));
}

void ProgramWriter::lose_once(const std::string& what) {
  if (said_.insert(what).second) lose(what);
}

void ProgramWriter::refuse(std::string what, std::string expected) {
  refuse_as(without_form(std::move(what)), std::move(expected));
}

void ProgramWriter::refuse_unsaid(const std::string& problem, std::string expected) {
  if (said_.insert(problem).second) refuse_as(problem, std::move(expected));
}

void ProgramWriter::refuse_as(std::string problem, std::string expected) {
  if (!options_.allow_losses) fail({Code::TranslationRefused, place(), problem, expected});
  reporter_->set_file(std::string(file_));
  reporter_->report(Code::TranslationRefused, line_, 0, std::move(problem), std::move(expected));
}

void ProgramWriter::count_digits(std::string_view number) {
  const std::string_view whole = number.substr(0, number.find('.'));
  const auto count = [](std::string_view text) {
    return static_cast<int>(
        std::ranges::count_if(text, [](char c) { return c >= '0' && c <= '9'; }));
  };
  const bool is_fraction = whole == "0" || whole == "-0";
  const int n_whole = is_fraction ? 0 : count(whole);
  const int n = n_whole + count(number.substr(whole.size()));
  const bool fits_whole = n_whole <= digits_.n_whole;
  if (fits_whole && n <= digits_.n_digits) return;
  std::string expected = fmt::format("at most {} digits", digits_.n_digits);
  if (!fits_whole) expected += fmt::format(", {} of them before the point", digits_.n_whole);
  if (!options_.resolution) expected += ", or --resolution 0.1 for a control that reads more";
  fail({Code::NumberTooLong,
        place(),
        fits_whole ? fmt::format("{} has {} digits", quoted(number), n)
                   : fmt::format("{} has no place in {}", quoted(number), digits_.form()),
        std::move(expected)});
}

void ProgramWriter::lose_vision(const Setting& setting) {
  if (!setting.is_unperformed && !is_left_to_vision(setting.text)) return;
  reporter_->set_file(std::string(file_));
  reporter_->report(
      Code::TranslationLoss,
      line_,
      0,
      quoted(setting.text) + " is for the vision system, which has no part in this output");
}

void ProgramWriter::lose_tool_table() {
  for (const auto& [number, tool] : info_.tools) {
    if (tool.dwell) lose_once("the dwell of tools (A of the tool table)");
    if (!tool.magazines.empty()) lose_once("magazines of tools (M of the tool table)");
  }
}

bool ProgramWriter::serves_all_axes(const DepthOfCut& cut) {
  const Length rise = rise_of_others(cut);
  if (!(rise > kSamePlane)) return true;
  refuse(fmt::format("a plane for each Z axis: the surface under another one differs by {:.4g} um "
                     "from that under the first",
                     rise.in_um()),
         fmt::format("at most {:.4g} um", kSamePlane.in_um()));
  return false;
}

std::string_view ProgramWriter::words_of(std::string_view message) {
  if (info_.dialect != Dialect::SiebMeyer) return message;
  constexpr std::string_view kPark = "&P";
  if (message.starts_with(kPark)) {
    message.remove_prefix(kPark.size());
    lose("the park position before a message (&P)");
  }
  if (message.starts_with('!')) message.remove_prefix(1);
  return message;
}

std::string printable(std::string_view text) {
  std::string out(text);
  std::ranges::replace_if(
      out, [](char c) { return c < ' ' || c > '~'; }, '?');
  return out;
}

}  // namespace panelcal
