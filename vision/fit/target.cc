// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/target.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::array kShapes = {
#define PANELCAL_SHAPE(shape, word, size, detector, max_fitted) \
  std::pair{Shape::shape, std::string_view(word)},
#include "vision/fit/shapes.def"
};
constexpr std::array kSizes = {
#define PANELCAL_SHAPE(shape, word, size, detector, max_fitted) \
  std::pair{Shape::shape, std::string_view(size)},
#include "vision/fit/shapes.def"
};
constexpr std::array kPolarities = {std::pair{Polarity::Bright, std::string_view("bright")},
                                    std::pair{Polarity::Dark, std::string_view("dark")}};

template <class Table, class Key>
std::string_view name_in(const Table& table, Key key) {
  for (const auto& [value, word] : table) {
    if (value == key) return word;
  }
  return {};
}

template <class Table>
auto value_in(const Table& table, std::string_view name) {
  std::optional<typename Table::value_type::first_type> found;
  for (const auto& [value, word] : table) {
    if (word == name) found = value;
  }
  return found;
}

tl::unexpected<Diagnostic> invalid(const Target& target, std::string what, std::string expected) {
  return failure({Code::TargetInvalid,
                  {},
                  fmt::format("vision tool {}: {}", target.number, what),
                  std::move(expected)});
}

bool is_positive(double v) {
  return std::isfinite(v) && v > 0;
}

}  // namespace

std::string_view name(Shape shape) {
  return name_in(kShapes, shape);
}

std::string_view name(Polarity polarity) {
  return name_in(kPolarities, polarity);
}

std::string_view size_words(Shape shape) {
  return name_in(kSizes, shape);
}

std::optional<Shape> shape_from_name(std::string_view name) {
  return value_in(kShapes, name);
}

std::optional<Polarity> polarity_from_name(std::string_view name) {
  return value_in(kPolarities, name);
}

namespace {

constexpr int kMaxDots = 64;

/// A target's lengths in one of its two units, as plain numbers.
struct TargetLengths {
  double size = 0;
  std::optional<double> inner;
  std::optional<double> width;
  std::string_view unit;
};

TargetLengths lengths_of(const Target& target) {
  const auto mm_of = [](const std::optional<Length>& length) {
    return length ? std::optional(length->in_mm()) : std::nullopt;
  };
  const auto px_of = [](const std::optional<PixelLength>& length) {
    return length ? std::optional(length->in_px()) : std::nullopt;
  };
  if (target.size) {
    return {target.size->in_mm(), mm_of(target.inner_size), mm_of(target.width), "mm"};
  }
  return {target.size_px->in_px(), px_of(target.inner_size_px), px_of(target.width_px), "px"};
}

/// A length that only `owner` has, between 0 and the size.
Expected<void> validate_part(const Target& target,
                             std::string_view name,
                             const std::optional<double>& length,
                             const TargetLengths& lengths,
                             Shape owner) {
  if (!length) return {};
  if (target.shape != owner) {
    return invalid(target,
                   fmt::format("{}_{} = {}", name, lengths.unit, *length),
                   fmt::format("none: not a {}", panelcal::name(owner)));
  }
  if (!is_positive(*length) || *length >= lengths.size) {
    return invalid(target,
                   fmt::format("{}_{} = {}", name, lengths.unit, *length),
                   fmt::format("a number between 0 and size_{} = {}", lengths.unit, lengths.size));
  }
  return {};
}

Expected<void> validate_lengths(const Target& target) {
  const TargetLengths lengths = lengths_of(target);
  if (!is_positive(lengths.size)) {
    return invalid(
        target, fmt::format("size_{} = {}", lengths.unit, lengths.size), "a number above 0");
  }
  PANELCAL_CHECK(validate_part(target, "inner_size", lengths.inner, lengths, Shape::Ring));
  PANELCAL_CHECK(validate_part(target, "width", lengths.width, lengths, Shape::Cross));
  if (target.shape == Shape::Cross && !lengths.width) {
    return invalid(target, "a cross without the width of its bars", "width_mm or width_px");
  }
  return {};
}

Expected<void> validate_dots(const Target& target) {
  if (target.shape != Shape::Dots) {
    return target.dots.empty() ? Expected<void>() : invalid(target, "dots", "none: not a dot-code");
  }
  if (target.dots.size() < 2 || target.dots.size() > kMaxDots) {
    return invalid(target,
                   fmt::format("{} dots", target.dots.size()),
                   fmt::format("2 to {} of them", kMaxDots));
  }
  const double size = lengths_of(target).size;
  for (std::size_t i = 0; i < target.dots.size(); ++i) {
    if (!target.dots[i].allFinite()) return invalid(target, "a dot is nowhere", "finite numbers");
    for (std::size_t j = 0; j < i; ++j) {
      if ((target.dots[i] - target.dots[j]).norm() < size) {
        return invalid(target,
                       fmt::format("dots {} and {} overlap", j + 1, i + 1),
                       "dots at least their diameter apart");
      }
    }
  }
  return {};
}

}  // namespace

Expected<void> Target::validate() const {
  if (size.has_value() == size_px.has_value()) {
    return invalid(*this,
                   size ? "size_mm and size_px are both given" : "missing key \"size_mm\"",
                   "one of size_mm and size_px");
  }
  if (size && inner_size_px) return invalid(*this, "inner_size_px beside size_mm", "one unit");
  if (size_px && inner_size) return invalid(*this, "inner_size_mm beside size_px", "one unit");
  if (size && width_px) return invalid(*this, "width_px beside size_mm", "one unit");
  if (size_px && width) return invalid(*this, "width_mm beside size_px", "one unit");
  if (!is_positive(size_tolerance) || size_tolerance > 0.5) {
    return invalid(
        *this, fmt::format("size_tolerance = {}", size_tolerance), "above 0 and at most 0.5");
  }
  if (!(std::abs(angle.in_rad()) <= deg(360).in_rad())) {
    return invalid(*this, "its angle is out of range", "-360 to 360 degrees");
  }
  if (!(angle_tolerance.in_rad() >= 0 && angle_tolerance.in_rad() <= deg(180).in_rad())) {
    return invalid(*this, "its angle_tolerance is out of range", "0 to 180 degrees");
  }
  PANELCAL_CHECK(validate_lengths(*this));
  PANELCAL_CHECK(validate_dots(*this));
  if ((shape == Shape::Template) != (picture != nullptr)) {
    return invalid(*this,
                   picture ? "a picture" : "a template without its picture",
                   picture ? "none: not a template" : "picture = \"FILE\"");
  }
  return {};
}

}  // namespace panelcal
