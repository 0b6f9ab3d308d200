// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/surface/change.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace panelcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Probes of two maps that are nearer than this stand at the same place.
constexpr double kSameProbePlace_mm = 0.5;

/// Sigma of a map's probes, as the map knows it.
double sigma_mm(const StoredMap& stored, const ProbePoint& probe) {
  return stored.map.surface().noise_factor() * probe.measured.sigma.in_mm();
}

/// Over the later map's probes.
Expected<Measured> rms_of_change(const StoredMap& before, const StoredMap& after) {
  PANELCAL_TRY(const SurfaceFit was, predictor_of(before));
  PANELCAL_TRY(const SurfaceFit is, predictor_of(after));
  std::vector<Position<frame::Nominal>> places;
  for (const std::size_t i : after.map.kept()) {
    if (before.map.height_at(after.points[i].place)) places.push_back(after.points[i].place);
  }
  const auto n = static_cast<Index>(places.size());
  const std::vector<double> was_mm = was.heights_mm(places);
  const std::vector<double> is_mm = is.heights_mm(places);
  const VectorXd change_mm = VectorXd::Map(is_mm.data(), n) - VectorXd::Map(was_mm.data(), n);
  const MatrixXd cov_mm2 = was.covariance_mm2(places) + is.covariance_mm2(places);
  const double square_mm2 = change_mm.squaredNorm();
  // By how much the length of the change errs along itself; where there is none, in all.
  const double variance_mm2 =
      square_mm2 > 0 ? change_mm.dot(cov_mm2 * change_mm) / square_mm2 : cov_mm2.trace();
  const auto count = static_cast<double>(n);
  return Measured{std::sqrt(square_mm2 / count), std::sqrt(std::max(0.0, variance_mm2) / count)};
}

/// Earlier height of a place: of a probe that the earlier map left out there, or of the map.
struct WasThere {
  Measured height_mm;
  bool is_known = false;
};

std::optional<WasThere> was_at(const StoredMap& before, const Position<frame::Nominal>& place) {
  for (const SurfaceOutlier& outlier : before.map.outliers()) {
    const ProbePoint& probe = before.points[outlier.i_point];
    if ((probe.place - place).in_mm().norm() > kSameProbePlace_mm) continue;
    return WasThere{{probe.measured.height.in_mm(), sigma_mm(before, probe)}, true};
  }
  const auto height = before.map.height_at(place);
  if (!height) return std::nullopt;
  return WasThere{{height->height.in_mm(), height->sigma.in_mm()}, false};
}

}  // namespace

Expected<SurfaceChange> change_between(const StoredMap& before, const StoredMap& after) {
  SurfaceChange out;
  PANELCAL_TRY(out.difference, difference_of(before, after));
  PANELCAL_TRY(out.rms_mm, rms_of_change(before, after));
  out.greatest_mm = {out.difference.greatest.in_mm(), out.difference.greatest_sigma.in_mm()};
  out.greatest_at_mm = out.difference.greatest_at.in_mm();
  for (const SurfaceOutlier& outlier : after.map.outliers()) {
    const ProbePoint& probe = after.points[outlier.i_point];
    const auto was = was_at(before, probe.place);
    if (!was) continue;
    out.n_known += was->is_known ? 1 : 0;
    const double change_mm = probe.measured.height.in_mm() - was->height_mm.value;
    if (std::abs(change_mm) <= std::abs(out.greatest_mm.value)) continue;
    out.greatest_mm = {change_mm, std::hypot(was->height_mm.sigma, sigma_mm(after, probe))};
    out.greatest_at_mm = probe.place.in_mm();
    out.greatest_probe = outlier.name;
  }
  return out;
}

}  // namespace panelcal
