// SPDX-License-Identifier: Apache-2.0
#include "program/judge/explain.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "calib/base/append_format.h"
#include "program/judge/place_budget.h"
#include "program/judge/stated_risk.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string point(const Eigen::Vector2d& p_mm) {
  return fmt::format("({:.6f}, {:.6f}) mm", p_mm.x() + 0.0, p_mm.y() + 0.0);
}

std::string map_text(const Eigen::Matrix2d& a, const Eigen::Vector2d& t_mm) {
  return fmt::format("x' = {:.9g} x {:+.9g} y {:+.6f}, y' = {:.9g} x {:+.9g} y {:+.6f}",
                     a(0, 0),
                     a(0, 1),
                     t_mm.x(),
                     a(1, 0),
                     a(1, 1),
                     t_mm.y());
}

std::string source_line(std::string_view bytes, int number) {
  LineCursor cursor(bytes);
  while (!cursor.at_end()) {
    const SourceLine line = cursor.next();
    if (line.number == number) return std::string(line.text);
  }
  return "";
}

const PlacedPoint* placed_point_of(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) return drill;
  if (const auto* rout = std::get_if<Rout>(&operation.what)) return rout;
  if (const auto* move = std::get_if<RapidMove>(&operation.what)) return move;
  if (const auto* slot = std::get_if<Slot>(&operation.what)) return &slot->end;
  if (const auto* steps = std::get_if<StepSlot>(&operation.what)) return &steps->end;
  return nullptr;
}

const DepthOfCut* cut_of(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) return &drill->cut;
  if (const auto* rout = std::get_if<Rout>(&operation.what)) return &rout->cut;
  if (const auto* slot = std::get_if<Slot>(&operation.what)) return &slot->cut;
  return nullptr;
}

/// Empty where the machine's own plane holds.
std::string depth_text(const DepthOfCut& cut) {
  std::string text;
  if (cut.z) text = fmt::format("to {:.4f} mm above the table", cut.z->in_mm());
  if (cut.depth) {
    text = fmt::format("{:.4f} mm below the board's surface", cut.depth->in_mm());
  } else if (cut.is_controlled()) {
    text = "below the board's surface, as deep as the operator sets (no K#)";
  }
  if (!cut.surface) return text;
  text += fmt::format("{}surface measured {:.4f} mm above the table",
                      text.empty() ? "" : ", ",
                      cut.surface->in_mm());
  if (!cut.predicted) return text;
  return text + fmt::format(" by the map, sigma {:.2f} um ({})",
                            cut.predicted->sigma.in_um(),
                            name(cut.predicted->source));
}

/// The errors are independent, so their shares are of the variance.
std::string depth_budget_text(const JudgedDepth& judged) {
  const DepthError& error = judged.error;
  std::string text = fmt::format("  budget      {:>23}{:>8}\n", "sigma um", "share %");
  std::string unknown;
  const auto row = [&](std::string_view source, Length sigma) {
    if (!(sigma > Length())) {
      unknown += fmt::format("{}{}", unknown.empty() ? "" : ", ", source);
      return;
    }
    const double share = sigma / error.sigma;
    text += fmt::format("    {:<24}{:>9.3f}{:>8.1f}\n", source, sigma.in_um(), 100 * share * share);
  };
  row("map of the surface", error.map_sigma);
  if (error.reference_sigma > Length()) row("reference of the grid", error.reference_sigma);
  row("depth_um", error.machine_sigma);
  row("total", error.sigma);
  if (!unknown.empty()) text += "    not stated: " + unknown + "\n";
  const auto side = [](std::string_view word, const std::optional<Length>& limit, double risk) {
    if (!limit) return std::string();
    return fmt::format("; more than {:.4g} um too {}: {}", limit->in_um(), word, risk_text(risk));
  };
  return text + "  error       " + error_text(error) +
         side("shallow", judged.tolerance.too_shallow, judged.risk.too_shallow) +
         side("deep", judged.tolerance.too_deep, judged.risk.too_deep) + "\n";
}

std::string budget_row(std::string_view source,
                       const Eigen::Matrix2d& cov_mm2,
                       double share,
                       std::string_view shared) {
  return fmt::format("    {:<24}{:>9.3f}{:>9.3f}{:>8.1f}  {}\n",
                     source,
                     std::sqrt(std::max(0.0, cov_mm2(0, 0))) * 1e3,
                     std::sqrt(std::max(0.0, cov_mm2(1, 1))) * 1e3,
                     100 * share,
                     shared);
}

/// The share is of the variances in x and y together. Sources that nothing is known of are named:
/// they are zero in the sum, not on the machine.
std::string budget_text(const ErrorBudget& budget) {
  const double whole_mm2 = total_mm2(budget).trace();
  if (!(whole_mm2 > 0)) return {};
  std::string text = fmt::format(
      "  budget      {:>23}{:>9}{:>8}  {}\n", "sigma x", "y um", "share %", "common to");
  std::string unknown;
  for (const BudgetTerm& term : budget) {
    if (term.counts()) {
      text += budget_row(
          term.source, term.cov_mm2, term.cov_mm2.trace() / whole_mm2, name(term.shared));
    } else {
      unknown += fmt::format("{}{}", unknown.empty() ? "" : ", ", term.source);
    }
  }
  text += budget_row("total", total_mm2(budget), 1, "");
  text.erase(text.find_last_not_of(" \n") + 1);
  text += '\n';
  return unknown.empty() ? text : text + "    not stated: " + unknown + "\n";
}

/// Empty where places were measured with the offset of the machine's file.
std::string calibration_text(const CalibrationAnswer* calibration) {
  if (calibration == nullptr) return {};
  const CalibrationOrder& order = calibration->order;
  return fmt::format("    measured with the spindle-camera offset {} that {} in line {} gave\n",
                     point(calibration->offset->offset.in_mm()),
                     order.command,
                     order.line);
}

}  // namespace

std::optional<ExplainChoice> parse_explain_choice(std::string_view text) {
  const bool is_line = text.starts_with('L');
  if (is_line) text.remove_prefix(1);
  std::int64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || value < 1) return std::nullopt;
  if (!is_line) return ExplainChoice{.line = std::nullopt, .number = value};
  if (value > 2'000'000'000) return std::nullopt;
  return ExplainChoice{.line = static_cast<int>(value), .number = std::nullopt};
}

void Explainer::put(const Operation& operation) {
  if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    tool_ = change->tool;
    if (depths_) depths_->take(*change);
  }
  const PlacedPoint* place = placed_point_of(operation);
  if (place == nullptr || operation.origin == nullptr) return;
  ++n_places_;
  const bool is_meant = choice_.line ? operation.file.empty() && operation.line == *choice_.line
                                     : n_places_ == *choice_.number;
  if (is_meant && ++n_matching_ <= kMost) explain(operation, *place);
}

void Explainer::explain(const Operation& operation, const PlacedPoint& place) {
  const Origin& origin = *operation.origin;
  const bool is_main = operation.file.empty();
  const std::string file = is_main ? program_.source.file : std::string(operation.file);
  std::string line;
  if (is_main) line = source_line(program_.source.bytes, operation.line);
  for (const auto& [name, pattern] : program_.patterns) {
    if (!is_main && pattern.file == file) line = source_line(pattern.bytes, operation.line);
  }
  if (!text_.empty()) text_ += '\n';
  internal::append_format(text_,
                          "{} {}: {}:{}: {}\n",
                          operation_name(operation),
                          n_places_,
                          file,
                          operation.line,
                          line);
  internal::append_format(
      text_,
      "  tool        {}{}, taken in line {}\n",
      tool_.number,
      tool_.diameter ? fmt::format(", diameter {:.4f} mm", tool_.diameter->in_mm()) : "",
      origin.tool_line);
  internal::append_format(text_, "  programmed  {}\n", point(origin.programmed.in_mm()));
  internal::append_format(text_,
                          "  placement   path [{}]: {}\n",
                          fmt::join(operation.path, ","),
                          map_text(origin.placement->linear(), origin.placement->translation()));
  internal::append_format(text_, "  nominal     {}\n", point(place.nominal.in_mm()));
  if (origin.scaling != nullptr) {
    internal::append_format(text_,
                            "  scaling     {}\n",
                            map_text(origin.scaling->linear(), origin.scaling->translation()));
  }
  explain_correction(origin);
  internal::append_format(
      text_,
      "  corrected   {}, sigma ({:.3f}, {:.3f}) um{}\n",
      point(place.corrected.in_mm()),
      std::sqrt(place.cov_mm2(0, 0)) * 1e3,
      std::sqrt(place.cov_mm2(1, 1)) * 1e3,
      place.cov_mm2.trace() > 0 && !machine_.unstated().empty() ? " of the fit only" : "");
  text_ += budget_text(error_budget(budget_place(place, origin), survey_, machine_));
  explain_risk(place, origin);
  explain_depth(operation);
  internal::append_format(text_, "  work zero   {}\n", point(origin.work_zero->in_mm()));
  if (const Eigen::Vector2d table_mm = place.commanded.in_mm() - place.corrected.in_mm();
      !table_mm.isZero(0)) {
    internal::append_format(text_,
                            "  table map   ({:+.2f}, {:+.2f}) um to the command\n",
                            table_mm.x() * 1e3,
                            table_mm.y() * 1e3);
  }
  internal::append_format(text_, "  machine     {}\n", point(place.actual.in_mm()));
}

void Explainer::explain_correction(const Origin& origin) {
  if (origin.i_measurement) {
    const Measurement& target = survey_.measurements[*origin.i_measurement];
    internal::append_format(text_,
                            "  correction  none: {} target {} was measured at {}\n",
                            target.request.command,
                            target.request.seq,
                            point(target.measured.position.in_mm()));
    text_ += calibration_text(survey_.calibration_of(*origin.i_measurement));
    return;
  }
  if (*origin.base_series) explain_series("base", **origin.base_series);
  if (*origin.nested_series) explain_series("nested", **origin.nested_series);
  if (!*origin.base_series && !*origin.nested_series) text_ += "  correction  none in force\n";
}

void Explainer::explain_series(std::string_view name, std::size_t i_series) {
  const SeriesResult& series = survey_.series[i_series];
  internal::append_format(text_,
                          "  {:<11} {}, measured from line {}, path [{}]: {}{}\n",
                          name,
                          series.model_text(),
                          series.line,
                          fmt::join(series.path, ","),
                          series.is_smooth() ? "near " : "",
                          map_text(series.linear, series.translation_mm));
  text_ += calibration_text(survey_.calibration_of(series));
  if (series.assignment) text_ += "    chosen jointly: " + series.assignment->text() + "\n";
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const Measurement& target = survey_.measurements[series.points[i]];
    const Eigen::Vector2d& residual_mm = series.residuals_mm[i];
    internal::append_format(
        text_,
        "    {} target {}: nominal {}, measured {}, residual ({:+.3f}, {:+.3f}) um\n",
        target.request.command,
        target.request.seq,
        point(target.request.nominal.in_mm()),
        point(target.measured.position.in_mm()),
        residual_mm.x() * 1e3,
        residual_mm.y() * 1e3);
  }
  for (const std::size_t i : series.dropped) {
    const Measurement& target = survey_.measurements[i];
    internal::append_format(text_,
                            "    {} target {}: nominal {}, measured {}, left out of the fit\n",
                            target.request.command,
                            target.request.seq,
                            point(target.request.nominal.in_mm()),
                            point(target.measured.position.in_mm()));
  }
}

void Explainer::explain_risk(const PlacedPoint& place, const Origin& origin) {
  const std::optional<Length> radius = tolerances_.radius(tool_.number, tool_.diameter);
  if (!radius) return;
  const std::string risk = place.judged_risk
                               ? risk_words(place, budget_place(place, origin), survey_, machine_)
                               : "not known without a correction";
  internal::append_format(
      text_, "  tolerance   {:.4g} um, risk of breaking it {}\n", radius->in_um(), risk);
}

void Explainer::explain_depth(const Operation& operation) {
  const DepthOfCut* const cut = cut_of(operation);
  const std::string depth = cut == nullptr ? std::string() : depth_text(*cut);
  if (depth.empty()) return;
  text_ += "  depth       " + depth + "\n";
  if (cut->lower_limit) {
    text_ += fmt::format("  limit       no lower than {:.4f} mm above the table\n",
                         cut->lower_limit->in_mm());
  }
  if (!depths_) return;
  if (const auto judged = depths_->judge(operation)) text_ += depth_budget_text(*judged);
}

void PlaceNumber::put(const Operation& operation) {
  const PlacedPoint* place = placed_point_of(operation);
  if (place == nullptr || operation.origin == nullptr) return;
  ++n_places_;
  if (is_of_its_line_ || place->nominal != place_.nominal || operation.file != place_.file ||
      !std::ranges::equal(operation.path, place_.path)) {
    return;
  }
  is_of_its_line_ = operation.line == place_.line;
  if (is_of_its_line_ || operation.line < place_.line) number_ = n_places_;
}

std::string Explainer::text() const {
  if (n_matching_ == 0) {
    return choice_.line
               ? fmt::format("line {} drills and routs nothing\n", *choice_.line)
               : fmt::format("there is no place {}: the job has {}", *choice_.number, n_places_);
  }
  if (n_matching_ <= kMost) return text_;
  return text_ + fmt::format("\nand {} more places of this line\n", n_matching_ - kMost);
}

}  // namespace panelcal
