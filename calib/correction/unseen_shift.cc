// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/unseen_shift.h"

#include <cstddef>

namespace panelcal {

std::vector<UnseenShift> unseen_shifts(const CorrectionStack& stack,
                                       const Reliability* base,
                                       const Reliability* nested) {
  std::vector<UnseenShift> out;
  if (stack.smooth() != nullptr) return out;
  const std::vector<CorrectionStack::TargetInfluence> influences = stack.influences();
  const std::size_t n_base = stack.base() == nullptr ? 0 : stack.base()->pairs.size();
  const auto add = [&](const Reliability* reliability, bool is_nested) {
    if (reliability == nullptr) return;
    for (const UnseenError& error : reliability->unseen) {
      const std::size_t i = error.i_target + (is_nested ? n_base : 0);
      out.push_back({is_nested, &error, influences[i].by_measured * error.error_mm});
    }
  };
  add(base, false);
  add(nested, true);
  return out;
}

Length shift_at(const UnseenShift& shift, const Position<frame::Nominal>& nominal) {
  const double x = nominal.in_mm().x();
  const double y = nominal.in_mm().y();
  const Eigen::Matrix<double, 6, 1>& c = shift.coefficients;
  return mm(std::hypot(c[0] * x + c[1] * y + c[4], c[2] * x + c[3] * y + c[5]));
}

const UnseenShift* furthest(const std::vector<UnseenShift>& shifts,
                            const Position<frame::Nominal>& nominal) {
  const UnseenShift* out = nullptr;
  for (const UnseenShift& shift : shifts) {
    if (out == nullptr || shift_at(shift, nominal) > shift_at(*out, nominal)) out = &shift;
  }
  return out;
}

Eigen::Matrix<double, 6, 6> unseen_noise_cov(const CorrectionStack& stack,
                                             const Reliability* base,
                                             const Reliability* nested) {
  Eigen::Matrix<double, 6, 6> cov = Eigen::Matrix<double, 6, 6>::Zero();
  const std::size_t n_base = stack.base() == nullptr ? 0 : stack.base()->pairs.size();
  const std::vector<CorrectionStack::TargetInfluence> influences = stack.influences();
  for (std::size_t i = 0; i < influences.size(); ++i) {
    const Reliability* reliability = i < n_base ? base : nested;
    if (reliability == nullptr) continue;
    const CorrectionStack::TargetInfluence& target = influences[i];
    cov += (reliability->noise_ratio2 - 1) * target.by_measured * target.cov_mm2 *
           target.by_measured.transpose();
  }
  return cov;
}

}  // namespace panelcal
