// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "calib/base/statistics/median.h"
#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace panelcal::internal {
namespace {

/// Cells of the frame that may be on the wrong side of the threshold: debris, neighbours.
constexpr double kMaxWrongFrame = 0.2;
/// Levels of frame cells farther than this from their median, of the contrast, are not the frame's.
constexpr double kMostLight = 0.75;

/// Levels of a tag's cells, by rows; empty where they are not in the picture or covered.
struct CellLevels {
  int n_cells = 0;
  std::vector<std::optional<double>> levels;
  std::vector<bool> is_inside;  ///< the picture

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
  /// False if a level is beyond black or white by more than light and noise make it.
  bool is_plausible(int column, int row, double level) const {
    constexpr double kBeyond = 0.6;  // of the contrast
    const double middle = 0.5 * (black.at(column, row) + white.at(column, row));
    return std::abs(level - middle) < (0.5 + kBeyond) * std::abs(contrast);
  }
};

/// Medians over the middle of each cell: its rim is blurred, and debris on less than half of it
/// does not count.
///
/// In     light: of an earlier look, or null; with it pixels that are neither black nor white do
/// not
///        count, and cells that have few others are covered
CellLevels sample(const Image& image,
                  const TagFamily& family,
                  const TagQuad& quad,
                  const FrameLight* light) {
  constexpr double kLeastPlausible = 0.4;
  constexpr double kMiddle = 0.6;
  const Eigen::Matrix3d h = quad.image_from_tag();
  const double cell_px = quad.mean_side_px() / family.n_on_side;
  const int n_samples = std::clamp(static_cast<int>(std::lround(kMiddle * cell_px)), 1, 9);
  CellLevels out;
  out.n_cells = family.n_cells;
  std::vector<double> samples;
  for (int row = 0; row < family.n_cells; ++row) {
    for (int column = 0; column < family.n_cells; ++column) {
      samples.clear();
      bool is_inside = true;
      for (int k = 0; k < n_samples * n_samples; ++k) {
        const double dx = (k % n_samples + 0.5) / n_samples - 0.5;
        const double dy = (k / n_samples + 0.5) / n_samples - 0.5;
        const Eigen::Vector2d at(column + 0.5 + kMiddle * dx, row + 0.5 + kMiddle * dy);
        const Eigen::Vector2d v = (at.array() - 0.5 * family.n_cells).matrix() / family.n_on_side;
        const auto level = interpolated(image, (h * v.homogeneous()).hnormalized());
        is_inside = is_inside && level;
        if (level && (!light || light->is_plausible(column, row, *level))) {
          samples.push_back(*level);
        }
      }
      const bool is_seen = is_inside && static_cast<double>(samples.size()) >=
                                            kLeastPlausible * n_samples * n_samples;
      out.is_inside.push_back(is_inside);
      out.levels.push_back(is_seen ? std::optional(median(std::move(samples))) : std::nullopt);
    }
  }
  return out;
}

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
  std::array<std::vector<double>, 2> levels;  // of black cells, of white ones
  each_frame_cell([&](int column, int row, bool is_white) {
    ++n_frame;
    const auto& level = cells.at(column, row);
    if (!level) return;
    ++n_seen;
    levels[is_white ? 1 : 0].push_back(*level);
  });
  // Half of the frame may be the quiet zone, which may leave the picture.
  if (2 * n_seen < n_frame || levels[0].empty() || levels[1].empty()) return std::nullopt;
  const std::array medians = {median(levels[0]), median(levels[1])};
  // Light changes less than that across a tag; a covered cell may differ by more.
  const double most = kMostLight * std::abs(medians[1] - medians[0]);
  each_frame_cell([&](int column, int row, bool is_white) {
    const auto& level = cells.at(column, row);
    if (!level || std::abs(*level - medians[is_white ? 1 : 0]) > most) return;
    (is_white ? light.white : light.black).add(column, row, *level);
  });
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

/// The quad's cells as a word if the tag is turned by that number of quarters.
TagWord tag_word(const TagFamily& family,
                 const CellLevels& cells,
                 const FrameLight& light,
                 int quarters) {
  TagWord word;
  for (TagFamily::Bit bit : family.bits) {
    // A quarter carries the tag's bottom left corner to its bottom right one.
    for (int i = 0; i < quarters; ++i) bit = {bit.row, family.n_cells - 1 - bit.column};
    const auto& level = cells.at(bit.column, bit.row);
    const bool is_white = level && light.is_white(bit.column, bit.row, *level);
    word.bits = word.bits << 1 | (is_white ? 1U : 0U);
    word.is_seen = word.is_seen << 1 | (level ? 1U : 0U);
  }
  return word;
}

/// Chance that n tags in four turns have one so near to a random word.
double decode_chance(int n_tags, int n_bits, int wrong_bits) {
  double ways = 1;  // of having just this number of wrong bits
  double all = 1;
  for (int wrong = 1; wrong <= wrong_bits; ++wrong) {
    ways *= static_cast<double>(n_bits - wrong + 1) / wrong;
    all += ways;
  }
  return 4.0 * n_tags * all * std::exp2(-n_bits);
}

/// The nearest tag to what is seen of a word, and by how many bits the next one is farther off.
struct NearestTag {
  TagReading reading;
  int lead = 0;
};

NearestTag nearest_tag(const TagFamily& family, const std::array<TagWord, 4>& words) {
  NearestTag nearest;
  int second = static_cast<int>(family.bits.size()) + 1;
  nearest.reading.wrong_bits = second;
  for (int quarters = 0; quarters < 4; ++quarters) {
    const TagWord& word = words[static_cast<std::size_t>(quarters)];
    for (std::size_t id = 0; id < family.codes.size(); ++id) {
      const int wrong = std::popcount((word.bits ^ family.codes[id]) & word.is_seen);
      if (wrong >= nearest.reading.wrong_bits) {
        second = std::min(second, wrong);
        continue;
      }
      second = nearest.reading.wrong_bits;
      nearest.reading.wrong_bits = wrong;
      nearest.reading.id = static_cast<int>(id);
      nearest.reading.quarters = quarters;
    }
  }
  nearest.lead = second - nearest.reading.wrong_bits;
  return nearest;
}

}  // namespace

std::optional<TagReading> decoded(const TagFamily& family,
                                  const std::array<TagWord, 4>& words,
                                  std::optional<int> id) {
  constexpr int kLeastLead = 3;
  auto [reading, lead] = nearest_tag(family, words);
  const int n_seen = std::popcount(words[0].is_seen);
  reading.unseen_bits = static_cast<int>(family.bits.size()) - n_seen;
  const bool is_named = id && *id == reading.id;
  if (reading.wrong_bits > tolerable_wrong_bits(family, is_named, n_seen)) return std::nullopt;
  if (reading.wrong_bits + reading.unseen_bits > 0 && lead < kLeastLead) return std::nullopt;
  return reading;
}

int tolerable_wrong_bits(const TagFamily& family, bool id_is_named, int n_seen) {
  constexpr double kMaxChance = 2e-4;
  const int most = id_is_named ? 4 : 1;
  const int n_tags = id_is_named ? 1 : family.n_tags();
  int tolerable = n_seen == static_cast<int>(family.bits.size()) ? 0 : -1;
  for (int wrong = 0; wrong <= most && 2 * wrong < family.hamming_distance; ++wrong) {
    if (decode_chance(n_tags, n_seen, wrong) <= kMaxChance) tolerable = wrong;
  }
  return tolerable;
}

std::optional<TagReading> read_tag(const Image& image,
                                   const TagFamily& family,
                                   const TagQuad& quad,
                                   bool is_inverted,
                                   std::optional<int> id) {
  const TagPattern blank = family.blank();
  const auto first = light_of(blank, sample(image, family, quad, nullptr));
  if (!first || (first->contrast < 0) != is_inverted) return std::nullopt;
  const CellLevels cells = sample(image, family, quad, &*first);
  for (const TagFamily::Bit& bit : family.bits) {
    if (!cells.is_inside[static_cast<std::size_t>(bit.row * family.n_cells + bit.column)]) {
      return std::nullopt;
    }
  }
  const auto light = light_of(blank, cells);
  if (!light || (light->contrast < 0) != is_inverted) return std::nullopt;
  std::array<TagWord, 4> words;
  for (int quarters = 0; quarters < 4; ++quarters) {
    words[static_cast<std::size_t>(quarters)] = tag_word(family, cells, *light, quarters);
  }
  auto reading = decoded(family, words, id);
  if (reading) reading->contrast = light->contrast;
  return reading;
}

}  // namespace panelcal::internal
