// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/truth_comparison.h"

#include <algorithm>
#include <cmath>

#include "calib/base/append_format.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// d' C^-1 d, absent where C is singular (a hole without correction has no predicted error).
std::optional<double> normalized_square(const Eigen::Vector2d& d_mm,
                                        const Eigen::Matrix2d& cov_mm2) {
  const double det = cov_mm2(0, 0) * cov_mm2(1, 1) - cov_mm2(0, 1) * cov_mm2(1, 0);
  if (!(det > 0)) return std::nullopt;
  return (cov_mm2(1, 1) * d_mm.x() * d_mm.x() - 2 * cov_mm2(0, 1) * d_mm.x() * d_mm.y() +
          cov_mm2(0, 0) * d_mm.y() * d_mm.y()) /
         det;
}

}  // namespace

void ErrorStatistics::add(double error_mm) {
  ++n;
  max_mm = std::max(max_mm, error_mm);
  sum_mm += error_mm;
  sum_squares_mm2 += error_mm * error_mm;
}

Length ErrorStatistics::rms() const {
  return mm(n == 0 ? 0 : std::sqrt(sum_squares_mm2 / static_cast<double>(n)));
}

/// A hole at its own target follows it, which need not lie as the panel does: the program may have
/// drilled it.
Position<frame::Actual> TruthComparison::true_place(const Operation& operation,
                                                    const Drill& drill) const {
  if (operation.origin != nullptr && operation.origin->i_measurement) {
    const auto seq = static_cast<std::int64_t>(*operation.origin->i_measurement);
    const auto target = std::ranges::find(truth_.targets, seq, &Truth::Target::seq);
    if (target != truth_.targets.end()) return target->actual;
  }
  return truth_.actual_from_nominal(operation.path)(drill.nominal);
}

void TruthComparison::put(const Operation& operation) {
  const auto* drill = std::get_if<Drill>(&operation.what);
  if (drill == nullptr) return;
  const Eigen::Vector2d true_mm = true_place(operation, *drill).in_mm();
  // True place of the stage that is told so, and of one that is told the nominal place.
  Eigen::Vector2d drilled_mm = drill->commanded.in_mm();
  Eigen::Vector2d uncorrected_mm = drill->nominal.in_mm();
  if (truth_.table) {
    const Position<frame::Machine> work_zero = drill->actual - drill->commanded;
    drilled_mm += truth_.table->error_mm(drill->actual);
    uncorrected_mm +=
        truth_.table->error_mm(work_zero + displacement_mm<frame::Machine>(drill->nominal.in_mm()));
  }
  const Eigen::Vector2d error_mm = drilled_mm - true_mm;
  const double before_mm = (uncorrected_mm - true_mm).norm();
  for (Errors* errors : {&all_, &by_tool_[drill->tool]}) {
    errors->corrected.add(error_mm.norm());
    errors->uncorrected.add(before_mm);
  }
  Eigen::Matrix2d predicted_mm2 = drill->cov_mm2;
  if (of_pictures_ && operation.origin != nullptr) {
    predicted_mm2 = of_pictures_->at_mm2(budget_place(*drill, *operation.origin));
  }
  if (const auto square = normalized_square(error_mm, predicted_mm2)) {
    sum_normalized_squares_ += *square;
    n_normalized_ += 2;
  }
}

double TruthComparison::mean_normalized_square() const {
  return n_normalized_ == 0 ? 0 : sum_normalized_squares_ / static_cast<double>(n_normalized_);
}

std::string TruthComparison::summary() const {
  std::string out = fmt::format("{:>6} {:>8} {:>20} {:>20}\n{:>6} {:>8} {:>20} {:>20}\n",
                                "tool",
                                "holes",
                                "without correction",
                                "corrected",
                                "",
                                "",
                                "max / rms um",
                                "max / rms um");
  const auto row = [&](const std::string& name, const Errors& errors) {
    internal::append_format(out,
                            "{:>6} {:>8} {:>11.1f} / {:>6.1f} {:>12.3f} / {:>5.3f}\n",
                            name,
                            errors.corrected.n,
                            errors.uncorrected.max().in_um(),
                            errors.uncorrected.rms().in_um(),
                            errors.corrected.max().in_um(),
                            errors.corrected.rms().in_um());
  };
  for (const auto& [tool, errors] : by_tool_) row(fmt::format("T{}", tool), errors);
  row("all", all_);
  return out;
}

}  // namespace panelcal
