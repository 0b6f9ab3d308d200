// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/target.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::array kShapes = {std::pair{Shape::Disc, std::string_view("disc")},
                                std::pair{Shape::Ring, std::string_view("ring")}};
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

std::optional<Shape> shape_from_name(std::string_view name) {
  return value_in(kShapes, name);
}

std::optional<Polarity> polarity_from_name(std::string_view name) {
  return value_in(kPolarities, name);
}

namespace {

/// One unit's outer and inner size, as plain numbers, with the field's names for messages.
Expected<void> validate_sizes(const Target& target,
                              double size,
                              std::optional<double> inner,
                              std::string_view unit) {
  if (!is_positive(size)) {
    return invalid(target, fmt::format("size_{} = {}", unit, size), "a number above 0");
  }
  if (!inner) return {};
  if (target.shape != Shape::Ring) {
    return invalid(target, fmt::format("inner_size_{} = {}", unit, *inner), "none: not a ring");
  }
  if (!is_positive(*inner) || *inner >= size) {
    return invalid(target,
                   fmt::format("inner_size_{} = {}", unit, *inner),
                   fmt::format("a number between 0 and size_{} = {}", unit, size));
  }
  return {};
}

}  // namespace

Expected<void> Target::validate() const {
  if (size.has_value() == size_px.has_value()) {
    return invalid(*this,
                   size ? "size_mm and size_px are both given" : "no size",
                   "one of size_mm and size_px");
  }
  if (size && inner_size_px) return invalid(*this, "inner_size_px beside size_mm", "one unit");
  if (size_px && inner_size) return invalid(*this, "inner_size_mm beside size_px", "one unit");
  if (!is_positive(size_tolerance) || size_tolerance > 0.5) {
    return invalid(
        *this, fmt::format("size_tolerance = {}", size_tolerance), "above 0 and at most 0.5");
  }
  if (size) {
    std::optional<double> inner_mm;
    if (inner_size) inner_mm = inner_size->in_mm();
    return validate_sizes(*this, size->in_mm(), inner_mm, "mm");
  }
  std::optional<double> inner_px;
  if (inner_size_px) inner_px = inner_size_px->in_px();
  return validate_sizes(*this, size_px->in_px(), inner_px, "px");
}

}  // namespace panelcal
