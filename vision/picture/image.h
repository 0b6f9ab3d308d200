// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace panelcal {

/// A grey picture: rows of pixels, top row first, without gaps.
///
/// Values are grey levels from 0 to `full_scale()`, 255 or 65535, kept as float: both fit exactly.
class Image {
 public:
  static constexpr double kFullScale8 = 255;
  static constexpr double kFullScale16 = 65535;

  Image() = default;
  /// A picture of one level. Precondition: width, height >= 0.
  Image(int width, int height, double full_scale, float level = 0)
      : width_(width),
        height_(height),
        full_scale_(full_scale),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), level) {}

  int width() const { return width_; }
  int height() const { return height_; }
  double full_scale() const { return full_scale_; }
  bool empty() const { return pixels_.empty(); }

  std::span<const float> pixels() const& { return pixels_; }
  std::span<float> pixels() & { return pixels_; }
  std::span<const float> pixels() const&& = delete;  ///< would outlive the picture
  std::span<const float> row(int y) const { return {pixels_.data() + offset(y), n_columns()}; }
  std::span<float> row(int y) { return {pixels_.data() + offset(y), n_columns()}; }
  float at(int x, int y) const { return pixels_[offset(y) + static_cast<std::size_t>(x)]; }
  float& at(int x, int y) { return pixels_[offset(y) + static_cast<std::size_t>(x)]; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  std::size_t n_columns() const { return static_cast<std::size_t>(width_); }
  std::size_t offset(int y) const { return static_cast<std::size_t>(y) * n_columns(); }

  int width_ = 0;
  int height_ = 0;
  double full_scale_ = kFullScale8;
  std::vector<float> pixels_;
};

}  // namespace panelcal
