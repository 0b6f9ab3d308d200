// SPDX-License-Identifier: Apache-2.0
#include "tools/run/fits_summary.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>

#include "calib/base/append_format.h"
#include "calib/base/number_text.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

std::string focus_summary(const Survey& survey) {
  std::string out;
  for (const FocusResult& focus : survey.focus) {
    if (!focus.is_found) continue;
    out += fmt::format("focused at ({:.4f}, {:.4f}) mm (line {}): z = {:.4f} mm, sigma {:.1f} um\n",
                       focus.request.expected.in_mm().x(),
                       focus.request.expected.in_mm().y(),
                       focus.request.line,
                       focus.z.in_mm(),
                       focus.sigma.in_um());
  }
  return out;
}

/// They count for this job; the text says how to keep one.
std::string calibrations_summary(const Survey& survey) {
  constexpr std::size_t kMost = 20;
  const std::size_t n = survey.calibrations.size();
  std::string out;
  for (std::size_t i = 0; i < std::min(n, kMost); ++i) {
    const CalibrationAnswer& calibration = survey.calibrations[i];
    out += fmt::format(
        "{} (line {}): {}\n", calibration.order.command, calibration.order.line, calibration.text);
  }
  if (n > kMost) out += fmt::format("and {} more calibrations\n", n - kMost);
  if (n == 0) return out;
  return out +
         "calibrated for this job only: `panelcal calibrate spindle-camera --install` is for "
         "later ones\n";
}

/// Empty for a program that probes nothing.
std::string probes_summary(const Survey& survey) {
  if (survey.probes.empty()) return {};
  double low_mm = std::numeric_limits<double>::infinity();
  double high_mm = -low_mm;
  for (const ProbeReading& reading : survey.probes) {
    for (const HeightEstimate& height : reading.heights) {
      low_mm = std::min(low_mm, height.height.in_mm());
      high_mm = std::max(high_mm, height.height.in_mm());
    }
  }
  const auto n_found = std::ranges::count(survey.probes, ProbeStatus::Found, &ProbeReading::status);
  std::string out = fmt::format(
      "probed {}, {} found",
      survey.probes.size() == 1 ? "1 place" : fmt::format("{} places", survey.probes.size()),
      n_found);
  if (n_found > 0) {
    out += fmt::format(", surface from {:.4f} to {:.4f} mm above the table", low_mm, high_mm);
  }
  for (const FilledNode& node : survey.filled_nodes) {
    const HeightEstimate& height = node.heights.front();
    out += fmt::format(
        "\nnot probed, {}: ({:.4f}, {:.4f}) mm of the grid, {:.4f} mm high, sigma "
        "{:.1f} um",
        name(node.source),
        node.place.in_mm().x(),
        node.place.in_mm().y(),
        height.height.in_mm(),
        height.sigma.in_um());
  }
  return out + "\n";
}

/// Of series that a gate refuses and no diagnostic explains.
std::string causes_summary(const Survey& survey) {
  std::string out;
  for (const SeriesResult& series : survey.series) {
    if (!series.fault || series.fault->is_resolved || series.fault->false_alarm > 0) continue;
    out += fmt::format("likely cause (series of line {}): {}\n", series.line, series.fault->text());
  }
  return out;
}

/// Of series whose pictures had several candidates. What is held says a diagnostic.
std::string assignments_summary(const Survey& survey) {
  std::string out;
  for (const SeriesResult& series : survey.series) {
    if (!series.assignment || !series.assignment->is_certain()) continue;
    out += fmt::format("chosen jointly (series of line {}) among {} candidates: {}\n",
                       series.line,
                       fmt::join(series.assignment->n_candidates, ", "),
                       series.assignment->text());
  }
  return out;
}

/// Of series whose targets do not agree, and whose sigma has grown by it.
std::string misfits_summary(const Survey& survey) {
  std::string out;
  for (const SeriesResult& series : survey.series) {
    if (series.misfit_ratio == 1) continue;
    out += fmt::format("misfit (series of line {}): sigma of its fit grows {:.1f} times\n",
                       series.line,
                       series.misfit_ratio);
  }
  return out;
}

/// "models of 12 nested fits: 10 offset, 2 rigid"
std::string nested_models_line(const Survey& survey) {
  std::map<PanelModel, int> count;
  int n = 0;
  for (const SeriesResult& series : survey.series) {
    if (!series.nested || !series.chose_model) continue;
    ++count[series.model];
    ++n;
  }
  if (n == 0) return {};
  std::string out = fmt::format("models of {}:", internal::counted(n, "nested fit"));
  std::string_view separator = " ";
  for (const auto& [model, n_fits] : count) {
    out += fmt::format("{}{} {}", separator, n_fits, name(model));
    separator = ", ";
  }
  return out + "\n";
}

/// The gates of base and of nested fits.
std::string gates_summary(const Survey& survey) {
  std::string out;
  for (const CorrectionLevel level : {CorrectionLevel::Base, CorrectionLevel::Nested}) {
    const auto first = std::ranges::find(survey.series, level, &SeriesResult::level);
    if (first == survey.series.end()) continue;
    out += fmt::format("gates of {} fits: {}\n",
                       level == CorrectionLevel::Base ? "panel" : "nested",
                       gates_text(first->limits));
  }
  return out;
}

}  // namespace

std::string fits_summary(const Survey& survey) {
  std::string out = focus_summary(survey) + calibrations_summary(survey);
  const auto n_found =
      std::ranges::count(survey.measurements, MeasurementStatus::Found, &Measurement::status);
  if (!survey.measurements.empty() || survey.probes.empty()) {
    const auto n_skipped =
        std::ranges::count(survey.measurements, MeasurementStatus::Skipped, &Measurement::status);
    internal::append_format(out,
                            "measured {} targets, {} found{}\n",
                            survey.measurements.size(),
                            n_found,
                            n_skipped > 0 ? fmt::format(", {} skipped", n_skipped) : "");
  }
  for (const SeriesResult* const board : survey.left_out_boards()) {
    internal::append_format(out,
                            "board {} (line {}) is left out: nothing of it is drilled\n",
                            fmt::join(board->path, "."),
                            board->line);
  }
  out += probes_summary(survey);
  out += assignments_summary(survey) + causes_summary(survey);
  std::size_t n_nested = 0;
  double worst_nested_um = 0;
  for (const SeriesResult& series : survey.series) {
    if (series.nested) {
      ++n_nested;
      worst_nested_um = std::max(worst_nested_um, series.worst_residual_um());
    }
    if (!series.base) continue;
    out += series.full(fmt::format("panel (line {})", series.line));
    if (series.layer_spread) {
      internal::append_format(out,
                              "panel (line {}): layers of a target at most {:.3f} um apart\n",
                              series.line,
                              series.layer_spread->in_um());
    }
  }
  if (n_nested > 0) {
    internal::append_format(
        out, "{} nested fits, worst residual {:.3f} um\n", n_nested, worst_nested_um);
    out += nested_models_line(survey);
  }
  return out + misfits_summary(survey) + gates_summary(survey);
}

}  // namespace panelcal
