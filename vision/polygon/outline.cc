// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "calib/base/statistics/median.h"
#include "vision/fit/gauss_table.h"
#include "vision/fit/regression.h"
#include "vision/polygon/quality.h"
#include "vision/polygon/solver.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// Regression of the picture on the model's share along one piece of an outline.
struct Piece {
  Regression levels;  ///< parts of the contrast
  double gg = 0;
  double rg = 0;
  double length = 0;  ///< pattern units; 0 where there is no outline

  /// In     model, value: as parts of the contrast; density: change of the model per px
  void add(double model, double value, double density) {
    gg += density * density;
    rg += density * (value - model);
    levels.add(model, value);
  }
  double variance() const { return levels.model_square(); }
  bool is_seen() const { return levels.n >= 3 && variance() > 0.01 * levels.n && gg > 0; }
  /// Of the edge that is seen from the model's, px, if it is small.
  double shift_px() const { return rg / gg; }
};

/// The outline's pieces on one family of lines: between two crossing lines every line has several.
class Pieces {
 public:
  /// In     length: of the longest piece, pattern units
  Pieces(const CellPattern& pattern, bool is_x, double length)
      : pattern_(pattern),
        is_x_(is_x),
        lines_(is_x ? pattern.x : pattern.y),
        across_(is_x ? pattern.y : pattern.x) {
    first_.push_back(0);
    for (std::size_t j = 0; j + 1 < across_.size(); ++j) {
      const double run = across_[j + 1] - across_[j];
      const int n = std::clamp(static_cast<int>(std::ceil(run / length)), 1, 64);
      first_.push_back(first_.back() + static_cast<std::size_t>(n));
    }
    pieces_.resize(lines_.size() * first_.back());
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      for (std::size_t j = 0; j + 1 < across_.size(); ++j) {
        if (!is_outline(i, j)) continue;
        const double n = static_cast<double>(first_[j + 1] - first_[j]);
        for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) {
          pieces_[i * first_.back() + k].length = (across_[j + 1] - across_[j]) / n;
        }
      }
    }
  }

  /// The nearest piece to a place and its distance, pattern units; null if there is none.
  struct Nearest {
    Piece* piece = nullptr;
    double distance = 0;
  };
  Nearest nearest(const Eigen::Vector2d& v, double growth) {
    const double along = is_x_ ? v.y() : v.x();
    const double at = is_x_ ? v.x() : v.y();
    const auto next = std::upper_bound(across_.begin(), across_.end(), along);
    if (next == across_.begin() || next == across_.end()) return {};
    const auto j = static_cast<std::size_t>(next - across_.begin()) - 1;
    const double part = (along - across_[j]) / (across_[j + 1] - across_[j]);
    const std::size_t n = first_[j + 1] - first_[j];
    const std::size_t k =
        first_[j] + std::min(n - 1, static_cast<std::size_t>(part * static_cast<double>(n)));
    Nearest best;
    const std::vector<double>& way = is_x_ ? pattern_.x_growth : pattern_.y_growth;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      Piece& piece = pieces_[i * first_.back() + k];
      const double line = lines_[i] + (way.empty() ? 0 : growth * way[i]);
      const double distance = std::abs(at - line);
      if (piece.length > 0 && (!best.piece || distance < best.distance)) best = {&piece, distance};
    }
    return best;
  }

  const std::vector<Piece>& all() const { return pieces_; }
  std::size_t n_on_line() const { return first_.back(); }
  /// Two sides, as a square has them.
  bool is_pair() const { return lines_.size() == 2 && across_.size() == 2; }

 private:
  bool is_outline(std::size_t i, std::size_t j) const {
    const int line = static_cast<int>(i);
    const int row = static_cast<int>(j);
    const Cell a = is_x_ ? pattern_.at(line - 1, row) : pattern_.at(row, line - 1);
    const Cell b = is_x_ ? pattern_.at(line, row) : pattern_.at(row, line);
    return a != b && a != Cell::Unknown && b != Cell::Unknown;
  }

  const CellPattern& pattern_;
  bool is_x_;
  const std::vector<double>& lines_;
  const std::vector<double>& across_;
  std::vector<std::size_t> first_;
  std::vector<Piece> pieces_;
};

/// Lengths of the outline: all, seen, outside of the picture.
struct OutlineLengths {
  double all = 0;
  double seen = 0;
  double outside = 0;
  double weakest_side = 1;
  std::vector<double> side_contrasts;  ///< of a square's sides, over the whole's

  double evenness() const {
    if (side_contrasts.empty()) return 1;
    const auto [low, high] = std::minmax_element(side_contrasts.begin(), side_contrasts.end());
    return *high > 0 ? *low / *high : 0;
  }
};

void add_seen(const Pieces& pieces,
              double noise_of_contrast,
              double max_shift_px,
              OutlineLengths& lengths) {
  constexpr double kLeast = 0.4;  // local contrast over the whole's
  constexpr double kMost = 1.6;
  constexpr double kSlackSigmas = 2;
  constexpr double kMostSlack = 0.2;
  constexpr double kMostShiftSlackPx = 0.5;
  constexpr double kBlind = 0.5;  // sigma of a piece's contrast: it shows nothing
  double side = 0;
  double side_seen = 0;
  std::vector<double> contrasts;  // of the side's pieces
  for (std::size_t i = 0; i < pieces.all().size(); ++i) {
    const Piece& piece = pieces.all()[i];
    if (i % pieces.n_on_line() == 0) {
      side = side_seen = 0;
      contrasts.clear();
    }
    lengths.all += piece.length;
    side += piece.length;
    if (piece.length > 0 && !piece.is_seen()) {
      lengths.outside += piece.length;
    } else if (piece.length > 0) {
      const double sigma = noise_of_contrast / std::sqrt(piece.variance());
      const double slack = std::min(kMostSlack, kSlackSigmas * sigma);
      const double contrast = piece.levels.gain();
      contrasts.push_back(contrast);
      const double shift_slack =
          std::min(kMostShiftSlackPx, kSlackSigmas * noise_of_contrast / std::sqrt(piece.gg));
      const bool is_edge = contrast > kLeast - slack && contrast < kMost + slack &&
                           std::abs(piece.shift_px()) < max_shift_px + shift_slack;
      if (sigma < kBlind && is_edge) {
        lengths.seen += piece.length;
        side_seen += piece.length;
      }
    }
    if (pieces.is_pair() && (i + 1) % pieces.n_on_line() == 0 && side > 0) {
      lengths.weakest_side = std::min(lengths.weakest_side, side_seen / side);
      if (!contrasts.empty()) lengths.side_contrasts.push_back(median(contrasts));
    }
  }
}

}  // namespace

OutlineSeen outline_seen(const CellModel& model,
                         const CellState& state,
                         const std::vector<CellPixel>& pixels,
                         const CellNoise& noise) {
  constexpr double kBandSigmas = 2;
  // An edge may be this crooked, of the pattern's half extent; a disc in a square's place is more.
  constexpr double kCrooked = 0.06;
  constexpr double kLeastCrookedPx = 0.6;
  constexpr double kMostCrookedPx = 2;
  const double contrast = std::abs(state.levels[3]);
  if (!(contrast > 0)) return {};
  const Eigen::Matrix2d j = state.jacobian(state.to_frame({0, 0}));
  const double units_per_px = std::sqrt(std::abs(j.determinant()));
  const double band = (kBandSigmas * state.sigma_px + 0.5) * units_per_px;
  const double sigma = std::max(noise.inside, noise.outside) / contrast;
  // A pixel within the band has about a tenth of the contrast squared as variance.
  constexpr double kMostSigma = 0.25;
  const double certain_px =
      10 * std::pow(sigma / kMostSigma, 2) / (2 * kBandSigmas * state.sigma_px + 1);
  const double length = std::max({3.0, 2.5 * state.sigma_px, certain_px}) * units_per_px;
  Pieces x(model.pattern(), true, length);
  Pieces y(model.pattern(), false, length);
  CellView view(model, state);
  for (const CellPixel& pixel : pixels) {
    if (pixel.is_flat) continue;
    const Eigen::Vector2d v = state.to_pattern(pixel.at);
    auto nearest = x.nearest(v, state.growth);
    const auto other = y.nearest(v, state.growth);
    if (other.piece && (!nearest.piece || other.distance < nearest.distance)) nearest = other;
    if (!nearest.piece || nearest.distance > band) continue;
    const auto value = view.evaluate(pixel, nullptr);
    if (!value.is_known) continue;
    const Eigen::Vector3d terms = model.plane_terms(pixel.at);
    const double plane = terms.dot(state.levels.head<3>());
    const double t = nearest.distance / (units_per_px * state.sigma_px);
    nearest.piece->add(value.share,
                       (pixel.value - plane) / terms.dot(state.levels.tail<3>()),
                       gauss(t).pdf / state.sigma_px);
  }
  const double max_shift_px = std::clamp(
      kCrooked * half_extent(model.pattern()) / units_per_px, kLeastCrookedPx, kMostCrookedPx);
  OutlineLengths lengths;
  add_seen(x, sigma, max_shift_px, lengths);
  add_seen(y, sigma, max_shift_px, lengths);
  if (!(lengths.all > 0)) return {};
  return {lengths.seen / lengths.all,
          lengths.outside / lengths.all,
          lengths.weakest_side,
          lengths.evenness()};
}

}  // namespace panelcal::internal
