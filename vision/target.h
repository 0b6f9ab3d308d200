// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/base/units.h"

namespace panelcal {

enum class Shape { Disc, Ring };
enum class Polarity { Bright, Dark };  ///< the target against its surroundings

std::string_view name(Shape shape);
std::string_view name(Polarity polarity);
std::optional<Shape> shape_from_name(std::string_view name);
std::optional<Polarity> polarity_from_name(std::string_view name);

/// What to look for: a vision tool.
///
/// A size is the outer diameter. It is given in mm if pictures come with a camera mapping, or in
/// pixels if they do not; never both. The same holds for a ring's inner diameter, which may be
/// left out: then any hole is accepted.
struct Target {
  int number = 0;  ///< of the vision tool
  Shape shape = Shape::Disc;
  std::optional<Length> size;
  std::optional<PixelLength> size_px;
  std::optional<Length> inner_size;
  std::optional<PixelLength> inner_size_px;
  Polarity polarity = Polarity::Bright;
  /// Largest accepted deviation of the seen size, relative. Wide enough for etching and drilling
  /// tolerances, narrow enough to tell neighbouring pad sizes apart.
  double size_tolerance = 0.04;

  /// Fails  target-invalid: names the field, its value and the bound it breaks
  Expected<void> validate() const;
};

}  // namespace panelcal
