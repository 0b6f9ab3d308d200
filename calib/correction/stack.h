// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/panel/fit.h"
#include "calib/panel/smooth_panel.h"

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
///   whole = P1 a1 + P2 a2  =>  d whole = (P1 + P2 D) d a1(measured) + P2 d a2(measured)
///
/// with a1, a2 the coefficients of both maps and J as in TransformEstimate. Errors of the camera's
/// calibration are the same in all targets of both fits, so they are added up before squaring:
///
///   T = sum over targets of (d whole / d measured_i) by_camera_i,   cov += T cov(camera) T^T
///
/// for each calibrated camera. What the machine adds at a hole, and the spindle-camera offset, are
/// the same at every place and stand in the translation's part of the covariance.
///
/// A base panel that is bent smoothly has no six coefficients. Then base() is not affine; a place
/// and its covariance are those of the spline (calib/panel/smooth_panel.h), with T as above at the
/// place, and no nested correction may be on top of it.
class CorrectionStack {
 public:
  CorrectionStack();
  explicit CorrectionStack(MachineUncertainty machine);

  /// In     offset: of the spindle-camera offset that the targets were measured with; absent: the
  ///        machine's
  void set_base(std::shared_ptr<const BaseFit> fit,
                const std::optional<OffsetUncertainty>& offset = std::nullopt);
  /// A nested fit undoes the base fit's shift, and the base's offset with it: only its own counts.
  ///
  /// Precondition: the fit's base targets are base() of the targets' nominal places; !is_bent()
  void set_nested(std::shared_ptr<const NestedFit> fit,
                  const std::optional<OffsetUncertainty>& offset = std::nullopt);
  void clear_base();    ///< and the nested one (G37)
  void clear_nested();  ///< G47

  const BaseFit* base() const { return base_.get(); }
  const NestedFit* nested() const { return nested_.get(); }
  /// With the offset that the innermost fit in force was measured with.
  const MachineUncertainty& machine() const { return machine_; }

  /// The panel is bent: affine maps below are only the nearest ones, places are not theirs.
  bool is_bent() const { return smooth_ && smooth_->panel->is_bent(); }
  /// Place after the base fit, at which a nested target is looked for.
  Position<frame::Base> base_of(const Position<frame::Nominal>& nominal) const {
    return is_bent() ? smooth_->panel->map(nominal) : base_map_(nominal);
  }
  Position<frame::Actual> actual_of(const Position<frame::Nominal>& nominal) const {
    return is_bent() ? position_mm<frame::Actual>(base_of(nominal).in_mm()) : whole_.map(nominal);
  }
  /// Place at which a hole is drilled, with all that drilled_from_nominal() counts.
  PositionEstimate<frame::Actual> drilled(const Position<frame::Nominal>& nominal) const {
    return smooth_ ? drilled_smooth(nominal) : drilled_(nominal);
  }

  /// The base correction as base coordinates, or the affine map nearest to it.
  const Transform<frame::Base, frame::Nominal>& base_from_nominal() const { return base_map_; }
  /// The whole correction with the covariance of the fits, cameras' calibrations included;
  /// recomputed only when a correction changes.
  const TransformEstimate<frame::Actual, frame::Nominal>& actual_from_nominal() const {
    return whole_;
  }
  /// The same map with the covariance of what is drilled through it: the spindle-camera offset and
  /// what the machine adds at a hole are in it. Zero without a correction: nothing is known then.
  const TransformEstimate<frame::Actual, frame::Nominal>& drilled_from_nominal() const {
    return drilled_;
  }

  /// Response of the whole map to the measurements; first order, as above.
  struct TargetInfluence {
    Eigen::Matrix<double, 6, 2> by_measured;
    Eigen::Matrix2d cov_mm2;  ///< as the fit took it
    CameraJacobian by_camera;
    int i_camera = 0;
    int n_arrivals = 1;
  };
  /// Those of the base fit, then those of the nested one. Precondition: smooth() is null
  std::vector<TargetInfluence> influences() const;
  /// The base fit where its covariance is no affine map's; null otherwise.
  const SmoothPanelFit<frame::Base, frame::Nominal>* smooth() const {
    return smooth_ ? smooth_->panel.get() : nullptr;
  }
  /// Response of a place of smooth() to the measurements.
  struct PlaceInfluence {
    Eigen::Matrix2d by_measured;
    Eigen::Matrix2d cov_mm2;  ///< as the fit took it
    CameraJacobian by_camera;
    int i_camera = 0;
    int n_arrivals = 1;
  };
  /// Precondition: smooth() is not null
  std::vector<PlaceInfluence> influences_at(const Position<frame::Nominal>& nominal) const;
  /// The part of the covariance that comes from not knowing the panel's model; zero if it is given.
  Eigen::Matrix<double, 6, 6> choice_cov() const;
  /// The part that comes from targets that do not agree (calib/panel/misfit.h); zero if they do.
  Eigen::Matrix<double, 6, 6> misfit_cov() const;

 private:
  /// A place under a smooth base fit.
  struct SmoothBase {
    std::shared_ptr<const SmoothPanelFit<frame::Base, frame::Nominal>> panel;
    internal::CovarianceForm drilled;
  };

  /// The whole map's covariance by those of both fits.
  Eigen::Matrix<double, 6, 6> of_whole(const Eigen::Matrix<double, 6, 6>& base_cov,
                                       const Eigen::Matrix<double, 6, 6>& nested_cov) const;
  void compose();
  void compose_smooth();
  PositionEstimate<frame::Actual> drilled_smooth(const Position<frame::Nominal>& nominal) const;

  MachineUncertainty machine_;
  OffsetUncertainty machines_offset_;
  OffsetUncertainty base_offset_;
  OffsetUncertainty nested_offset_;
  std::shared_ptr<const BaseFit> base_;
  std::shared_ptr<const NestedFit> nested_;
  Transform<frame::Base, frame::Nominal> base_map_;
  TransformEstimate<frame::Actual, frame::Nominal> whole_;
  TransformEstimate<frame::Actual, frame::Nominal> drilled_;
  std::shared_ptr<const SmoothBase> smooth_;
};

/// T of above: d coefficients of the whole map / d parameters of one camera.
Eigen::Matrix<double, 6, 5> coefficients_by_camera(
    std::span<const CorrectionStack::TargetInfluence> influences, int i_camera);

}  // namespace panelcal
