// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "panelcal/calib/base/estimate.h"
#include "panelcal/calib/panel_fit.h"

namespace panelcal {

using BaseFit = PanelFit<frame::Base, frame::Nominal>;
using NestedFit = PanelFit<frame::Actual, frame::Base>;

/// The corrections in force: a base one, and a nested one that was measured on top of it.
///
///   actual = nested(base(nominal)),   each the identity while absent
///
/// A new base correction drops the nested one, which was relative to it (CNC-7 manual, G35, G36,
/// G45 to G47). The covariance of a corrected point counts how the nested fit takes up the errors
/// of the base fit: the nested targets were looked up through the base map, so an error there
/// moves what the nested fit is relative to, and the fit undoes it. To first order
///
///   a2 = a2(measured) + D a1,   D = -gain2 blockdiag(L2) [J(nominal_i)]
///
/// with a1, a2 the coefficients of both maps and J as in TransformEstimate.
class CorrectionStack {
 public:
  CorrectionStack();

  void set_base(std::shared_ptr<const BaseFit> fit);
  /// Precondition: the fit's base targets are base() of the targets' nominal places.
  void set_nested(std::shared_ptr<const NestedFit> fit);
  void clear_base();    ///< and the nested one (G37)
  void clear_nested();  ///< G47

  const BaseFit* base() const { return base_.get(); }
  const NestedFit* nested() const { return nested_.get(); }

  /// Where a nested target is looked for, as base coordinates.
  const Transform<frame::Base, frame::Nominal>& base_from_nominal() const { return base_map_; }
  /// The whole correction with its covariance; recomputed only when a correction changes.
  const TransformEstimate<frame::Actual, frame::Nominal>& actual_from_nominal() const {
    return whole_;
  }

 private:
  void compose();

  std::shared_ptr<const BaseFit> base_;
  std::shared_ptr<const NestedFit> nested_;
  Transform<frame::Base, frame::Nominal> base_map_;
  TransformEstimate<frame::Actual, frame::Nominal> whole_;
};

}  // namespace panelcal
