// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace panelcal::internal {
namespace {

/// Cells of the frame that may be on the wrong side of the threshold: debris, neighbours.
constexpr double kMaxWrongFrame = 0.2;

/// Levels of a tag's cells, by rows; empty where they are not in the picture.
struct CellLevels {
  int n_cells = 0;
  std::vector<std::optional<double>> levels;

  const std::optional<double>& at(int column, int row) const {
    return levels[static_cast<std::size_t>(row * n_cells + column)];
  }
};

std::optional<double> interpolated(const Image& image, const Eigen::Vector2d& u_px) {
  const double fx = std::floor(u_px.x());
  const double fy = std::floor(u_px.y());
  if (!(fx >= 0 && fy >= 0 && fx + 1 < image.width() && fy + 1 < image.height())) {
    return std::nullopt;
  }
  const int x = static_cast<int>(fx);
  const int y = static_cast<int>(fy);
  const double a = u_px.x() - fx;
  const double b = u_px.y() - fy;
  return (1 - b) * ((1 - a) * image.at(x, y) + a * image.at(x + 1, y)) +
         b * ((1 - a) * image.at(x, y + 1) + a * image.at(x + 1, y + 1));
}

/// Means over the middle half of each cell: its rim is blurred.
CellLevels sample(const Image& image, const TagFamily& family, const TagQuad& quad) {
  const Eigen::Matrix3d h = quad.image_from_tag();
  const double cell_px = quad.mean_side_px() / family.n_on_side;
  const int n_samples = std::clamp(static_cast<int>(std::lround(cell_px / 2)), 1, 5);
  CellLevels out;
  out.n_cells = family.n_cells;
  for (int row = 0; row < family.n_cells; ++row) {
    for (int column = 0; column < family.n_cells; ++column) {
      std::optional<double> sum = 0;
      for (int k = 0; sum && k < n_samples * n_samples; ++k) {
        const double dx = (k % n_samples + 0.5) / n_samples;
        const double dy = (k / n_samples + 0.5) / n_samples;
        const Eigen::Vector2d at(column + 0.25 + 0.5 * dx, row + 0.25 + 0.5 * dy);
        const Eigen::Vector2d v = (at.array() - 0.5 * family.n_cells).matrix() / family.n_on_side;
        const auto level = interpolated(image, (h * v.homogeneous()).hnormalized());
        sum = level ? std::optional(*sum + *level) : std::nullopt;
      }
      if (sum) *sum /= n_samples * n_samples;
      out.levels.push_back(sum);
    }
  }
  return out;
}

/// level = plane . (1, column, row) over some cells.
class Plane {
 public:
  void add(int column, int row, double level) {
    const Eigen::Vector3d terms(1, column, row);
    a_ += terms * terms.transpose();
    b_ += level * terms;
  }
  void solve() { plane_ = a_.ldlt().solve(b_); }
  double at(int column, int row) const { return plane_.dot(Eigen::Vector3d(1, column, row)); }

 private:
  Eigen::Matrix3d a_ = 1e-6 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d b_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d plane_ = Eigen::Vector3d::Zero();
};

/// The light on a tag, as its frame tells it.
struct FrameLight {
  Plane black;
  Plane white;
  double contrast = 0;  ///< in the middle

  bool is_white(int column, int row, double level) const {
    const double middle = 0.5 * (black.at(column, row) + white.at(column, row));
    return (level > middle) == (contrast > 0);
  }
};

std::optional<FrameLight> light_of(const TagPattern& blank, const CellLevels& cells) {
  FrameLight light;
  int n_seen = 0;
  int n_frame = 0;
  const auto each_frame_cell = [&](auto&& visit) {
    for (int row = 0; row < blank.n_cells; ++row) {
      for (int column = 0; column < blank.n_cells; ++column) {
        const TagCell cell = blank.at(column, row);
        if (cell != TagCell::Any) visit(column, row, cell == TagCell::White);
      }
    }
  };
  each_frame_cell([&](int column, int row, bool is_white) {
    ++n_frame;
    const auto& level = cells.at(column, row);
    if (!level) return;
    ++n_seen;
    (is_white ? light.white : light.black).add(column, row, *level);
  });
  // Half of the frame may be the quiet zone, which may leave the picture.
  if (3 * n_seen < 2 * n_frame) return std::nullopt;
  light.black.solve();
  light.white.solve();
  const int middle = blank.n_cells / 2;
  light.contrast = light.white.at(middle, middle) - light.black.at(middle, middle);
  int n_wrong = 0;
  each_frame_cell([&](int column, int row, bool is_white) {
    const auto& level = cells.at(column, row);
    n_wrong += level && light.is_white(column, row, *level) != is_white;
  });
  if (n_wrong > kMaxWrongFrame * n_seen) return std::nullopt;
  return light;
}

/// The code of the quad's cells if the tag is turned by that number of quarters.
std::uint64_t tag_code(const TagFamily& family, const std::vector<char>& is_white, int quarters) {
  std::uint64_t code = 0;
  for (TagFamily::Bit bit : family.bits) {
    // A quarter carries the tag's bottom left corner to its bottom right one.
    for (int i = 0; i < quarters; ++i) bit = {bit.row, family.n_cells - 1 - bit.column};
    const auto cell = static_cast<std::size_t>(bit.row * family.n_cells + bit.column);
    code = code << 1 | (is_white[cell] ? 1U : 0U);
  }
  return code;
}

/// The nearest of some ids, if it has no more wrong bits than allowed.
std::optional<TagReading> nearest_tag(const TagFamily& family,
                                      const std::array<std::uint64_t, 4>& words,
                                      std::size_t first_id,
                                      std::size_t last_id,
                                      int max_wrong_bits) {
  TagReading best;
  best.wrong_bits = max_wrong_bits + 1;
  for (int quarters = 0; quarters < 4; ++quarters) {
    for (std::size_t id = first_id; id <= last_id; ++id) {
      const int wrong = std::popcount(words[static_cast<std::size_t>(quarters)] ^ family.codes[id]);
      if (wrong >= best.wrong_bits) continue;
      best.wrong_bits = wrong;
      best.id = static_cast<int>(id);
      best.quarters = quarters;
    }
  }
  if (best.wrong_bits > max_wrong_bits) return std::nullopt;
  return best;
}

}  // namespace

std::optional<TagReading> decoded(const TagFamily& family,
                                  const std::array<std::uint64_t, 4>& words,
                                  std::optional<int> id) {
  if (id && *id >= 0 && *id < family.n_tags()) {
    const auto i = static_cast<std::size_t>(*id);
    if (const auto named = nearest_tag(family, words, i, i, tolerable_wrong_bits(family, true))) {
      return named;
    }
  }
  return nearest_tag(
      family, words, 0, family.codes.size() - 1, tolerable_wrong_bits(family, false));
}

int tolerable_wrong_bits(const TagFamily& family, bool id_is_named) {
  constexpr double kMaxChance = 2e-4;
  const int most = id_is_named ? 4 : 1;
  const auto n_bits = static_cast<double>(family.bits.size());
  const double n_words = 4 * (id_is_named ? 1.0 : static_cast<double>(family.n_tags()));
  double ways = 1;  // of having just so many wrong bits
  double all = 1;
  int tolerable = 0;
  for (int wrong = 1; wrong <= most && 2 * wrong < family.hamming_distance; ++wrong) {
    ways *= (n_bits - wrong + 1) / wrong;
    all += ways;
    if (n_words * all * std::exp2(-n_bits) > kMaxChance) break;
    tolerable = wrong;
  }
  return tolerable;
}

std::optional<TagReading> read_tag(const Image& image,
                                   const TagFamily& family,
                                   const TagQuad& quad,
                                   bool is_inverted,
                                   std::optional<int> id) {
  const CellLevels cells = sample(image, family, quad);
  for (const TagFamily::Bit& bit : family.bits) {
    if (!cells.at(bit.column, bit.row)) return std::nullopt;
  }
  const auto light = light_of(family.blank(), cells);
  if (!light || (light->contrast < 0) != is_inverted) return std::nullopt;
  std::vector<char> is_white(cells.levels.size(), 0);
  for (const TagFamily::Bit& bit : family.bits) {
    is_white[static_cast<std::size_t>(bit.row * family.n_cells + bit.column)] =
        light->is_white(bit.column, bit.row, *cells.at(bit.column, bit.row));
  }
  std::array<std::uint64_t, 4> words{};
  for (int quarters = 0; quarters < 4; ++quarters) {
    words[static_cast<std::size_t>(quarters)] = tag_code(family, is_white, quarters);
  }
  auto reading = decoded(family, words, id);
  if (reading) reading->contrast = light->contrast;
  return reading;
}

}  // namespace panelcal::internal
