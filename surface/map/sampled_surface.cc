// SPDX-License-Identifier: Apache-2.0
#include "surface/map/sampled_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

namespace panelcal::internal {
namespace {

using Eigen::Vector2d;
using SamplePlaces = std::vector<Position<frame::Nominal>>;

/// Greatest part that the lattice may add to a sigma, and the error that is always good enough.
constexpr double kMostLatticeError = 0.1;
constexpr double kGoodLatticeError_mm = 1e-5;
/// Cells by the side of the square that each probe has, at first; nodes at most, but for the edges:
/// of surfaces that are solved for, where each takes long, and for each probe of a grid.
constexpr double kFirstRefinement = 4;
constexpr double kMostNodes = 60000;
constexpr double kMostNodesOfGridProbe = 20;
/// Sigma of many probes is tried at this number of places; at all but a tenth it may miss this
/// share.
constexpr std::size_t kTriedSigmas = 300;
/// Up to this number of probes sigmas cost less than to look how fine they must be.
constexpr std::size_t kQuickSigmas = 50;
constexpr double kMostSigmaError = 0.1;
/// Places at which a lattice is tried in a cell, along either side: Hermite's polynomials miss most
/// in the middle if their slopes are right, and at (1 - 1/sqrt(3)) / 2 from the nodes if these are
/// not.
constexpr double kTried[] = {0.2113, 0.5, 0.7887};
/// Of all cells at most this number of places is tried, else evenly some of them.
constexpr std::size_t kMaxMapTrials = 30000;
/// One in this number of them, to reject a lattice.
constexpr std::size_t kFewTried = 17;

Position<frame::Nominal> sample_place(const Vector2d& p_mm) {
  return position_mm<frame::Nominal>(p_mm);
}

LatticeAxis axis(double low_mm, double high_mm, double step_mm) {
  const int n_cells = std::max(1, static_cast<int>(std::ceil((high_mm - low_mm) / step_mm)));
  return {low_mm, (high_mm - low_mm) / n_cells, n_cells + 1};
}

SamplePlaces nodes_of(const LatticeAxis& x, const LatticeAxis& y) {
  SamplePlaces out;
  for (int j = 0; j < y.n_nodes; ++j) {
    for (int i = 0; i < x.n_nodes; ++i) out.push_back(sample_place({x.at_mm(i), y.at_mm(j)}));
  }
  return out;
}

/// Places within the cells, all over them.
SamplePlaces tried_places(const LatticeAxis& x, const LatticeAxis& y) {
  constexpr std::size_t kByCell = std::size(kTried) * std::size(kTried);
  const auto n_columns = static_cast<std::size_t>(x.n_nodes - 1);
  const std::size_t n = n_columns * static_cast<std::size_t>(y.n_nodes - 1) * kByCell;
  std::size_t step = n / kMaxMapTrials + 1;
  // Else some of a cell's places would never be tried.
  if (step % std::size(kTried) == 0) ++step;
  SamplePlaces out;
  for (std::size_t k = 0; k < n; k += step) {
    const std::size_t cell = k / kByCell, place = k % kByCell;
    const auto i = static_cast<double>(cell % n_columns);
    const auto j = static_cast<double>(cell / n_columns);
    out.push_back(sample_place({x.first_mm + (i + kTried[place % std::size(kTried)]) * x.step_mm,
                                y.first_mm + (j + kTried[place / std::size(kTried)]) * y.step_mm}));
  }
  return out;
}

bool is_fine(const SurfaceFit& surface, const HeightLattice& sigmas) {
  const SamplePlaces all = tried_places(sigmas.x(), sigmas.y());
  SamplePlaces tried;
  for (std::size_t k = 0; k < kTriedSigmas; ++k) {
    tried.push_back(all[k * all.size() / kTriedSigmas]);
  }
  std::size_t n_off = 0;
  for (std::size_t k = 0; const HeightEstimate& right : surface.at(tried)) {
    const double sigma_mm = right.sigma.in_mm();
    const double error_mm = std::abs(sigmas.height_mm(tried[k++].in_mm()) - sigma_mm);
    if (error_mm > kMostSigmaError * sigma_mm) ++n_off;
  }
  return n_off <= kTriedSigmas / 10;
}

/// Samples sigmas that take long, as coarsely as possible, and not finer than step_mm.
Expected<HeightLattice> sample_sigmas(const SurfaceFit& surface,
                                      const Vector2d& low_mm,
                                      const Vector2d& high_mm,
                                      double step_mm) {
  double wide_mm = kFirstRefinement * step_mm;
  if (is_of_grid(surface.model())) wide_mm = step_mm;
  // About each probe sigma has a dip that is narrower than the heights need.
  if (surface.left_out().size() <= kQuickSigmas) wide_mm = 0.5 * step_mm;
  while (true) {
    const LatticeAxis x = axis(low_mm.x(), high_mm.x(), wide_mm);
    const LatticeAxis y = axis(low_mm.y(), high_mm.y(), wide_mm);
    std::vector<double> sigmas_mm;
    for (const HeightEstimate& node : surface.at(nodes_of(x, y))) {
      sigmas_mm.push_back(node.sigma.in_mm());
    }
    PANELCAL_TRY(HeightLattice sigmas,
                 HeightLattice::make(x, y, sigmas_mm, LatticeInterpolation::Bilinear));
    if (wide_mm <= step_mm || is_fine(surface, sigmas)) return sigmas;
    wide_mm *= 0.5;
  }
}

/// Error of the lattice of heights: its maximum, and whether it is small everywhere.
struct Missed {
  double worst_mm = 0;
  bool is_good = true;
};

/// In     stride: tries one in this number of places
Missed missed(const SurfaceFit& surface, const Sampled& sampled, std::size_t stride) {
  SamplePlaces tried;
  const SamplePlaces all = tried_places(sampled.heights.x(), sampled.heights.y());
  for (std::size_t i = 0; i < all.size(); i += stride) tried.push_back(all[i]);
  const std::vector<double> right_mm = surface.heights_mm(tried);
  Missed out;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const Vector2d& p_mm = tried[i].in_mm();
    const double error_mm = std::abs(sampled.heights.height_mm(p_mm) - right_mm[i]);
    out.worst_mm = std::max(out.worst_mm, error_mm);
    const double sigma_mm = sampled.sigmas.height_mm(p_mm);
    if (error_mm > std::max(kGoodLatticeError_mm, kMostLatticeError * sigma_mm)) {
      out.is_good = false;
    }
  }
  return out;
}

}  // namespace

Expected<Sampled> sample_finely(const SurfaceFit& surface,
                                const Vector2d& low_mm,
                                const Vector2d& high_mm,
                                double spacing_mm,
                                LatticeInterpolation interpolation) {
  const Vector2d size_mm = high_mm - low_mm;
  const auto n_probes = static_cast<double>(surface.left_out().size());
  const double most_nodes = is_of_grid(surface.model())
                                ? std::max(kMostNodes, kMostNodesOfGridProbe * n_probes)
                                : kMostNodes;
  // Probes that stand close may be few on what is extrapolated about them.
  double step_mm = std::max({spacing_mm / kFirstRefinement,
                             std::sqrt(size_mm.x() * size_mm.y() / most_nodes),
                             size_mm.maxCoeff() / most_nodes});
  PANELCAL_TRY(const HeightLattice sigmas, sample_sigmas(surface, low_mm, high_mm, step_mm));
  while (true) {
    const LatticeAxis x = axis(low_mm.x(), high_mm.x(), step_mm);
    const LatticeAxis y = axis(low_mm.y(), high_mm.y(), step_mm);
    PANELCAL_TRY(HeightLattice heights,
                 HeightLattice::make(x, y, surface.heights_mm(nodes_of(x, y)), interpolation));
    Sampled out{std::move(heights), sigmas};
    const double next_nodes = 4 * (size_mm.x() / step_mm + 1) * (size_mm.y() / step_mm + 1);
    const bool is_last = next_nodes > most_nodes;
    // A few places tell soon that a lattice is too coarse.
    if (is_last || missed(surface, out, kFewTried).is_good) {
      const Missed error = missed(surface, out, 1);
      out.error_mm = error.worst_mm;
      if (error.is_good || is_last) return out;
    }
    step_mm *= 0.5;
  }
}

}  // namespace panelcal::internal
