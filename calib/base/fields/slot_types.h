// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>

#include "calib/base/fields/field.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include <Eigen/Core>

// Not installed. Values of a member's type: what its key takes, how it is put in and taken out, and
// the unit at the key's end, which has to be one of the type's.
namespace panelcal::internal {

template <class T>
struct SlotTraits {
  using Dimension = void;  ///< of its values; void: a bare number, a text and so on
  using Element = void;    ///< of an optional or a list
  static constexpr bool is_optional = false;
  static constexpr bool is_place = false;
  static constexpr bool is_matrix = false;
  static constexpr std::size_t kRows = 0;  ///< 0: any number
  static constexpr std::size_t kColumns = 0;
};
template <class D>
struct SlotTraits<Quantity<D>> : SlotTraits<void> {
  using Dimension = D;
};
template <class F>
using PlaceDimension =
    std::conditional_t<kIsPixelFrame<F>, dimension::PixelLength, dimension::Length>;
template <class F>
struct SlotTraits<Position<F>> : SlotTraits<void> {
  using Dimension = PlaceDimension<F>;
  static constexpr bool is_place = true;
  static Position<F> of(double x, double y) { return make_position<F>({x, y}); }
};
template <class F>
struct SlotTraits<Displacement<F>> : SlotTraits<void> {
  using Dimension = PlaceDimension<F>;
  static constexpr bool is_place = true;
  static Displacement<F> of(double x, double y) { return make_displacement<F>({x, y}); }
};
template <class T>
struct SlotTraits<std::optional<T>> : SlotTraits<void> {
  using Dimension = typename SlotTraits<T>::Dimension;
  using Element = T;
  static constexpr bool is_optional = true;
  static constexpr std::size_t kRows = SlotTraits<T>::kRows;
  static constexpr std::size_t kColumns = SlotTraits<T>::kColumns;
};
template <class T>
struct SlotTraits<std::vector<T>> : SlotTraits<void> {
  using Dimension = typename SlotTraits<T>::Dimension;
  using Element = T;
};
template <class T, std::size_t n>
struct SlotTraits<std::array<T, n>> : SlotTraits<std::vector<T>> {
  static constexpr std::size_t kRows = n;
};
template <class T>
requires std::is_base_of_v<Eigen::MatrixBase<T>, T>
struct SlotTraits<T> : SlotTraits<void> {
  static constexpr bool is_matrix = true;
  static constexpr std::size_t kRows = T::RowsAtCompileTime > 0 ? T::RowsAtCompileTime : 0;
  static constexpr std::size_t kColumns = T::ColsAtCompileTime > 0 ? T::ColsAtCompileTime : 0;
};

/// The values that a member of this type takes.
template <class T>
constexpr FieldKind kind_of() {
  using Traits = SlotTraits<T>;
  if constexpr (Traits::is_optional) {
    return kind_of<typename Traits::Element>();
  } else if constexpr (Traits::is_matrix && !std::is_same_v<T, Eigen::Vector2d>) {
    return Traits::kColumns == 1 ? FieldKind::Numbers : FieldKind::Matrix;
  } else if constexpr (std::is_same_v<T, bool>) {
    return FieldKind::Truth;
  } else if constexpr (std::is_integral_v<T>) {
    return FieldKind::Whole;
  } else if constexpr (std::is_same_v<T, Eigen::Vector2d> || Traits::is_place) {
    return FieldKind::Pair;
  } else if constexpr (std::is_same_v<T, std::string>) {
    return FieldKind::Text;
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return FieldKind::File;
  } else if constexpr (std::is_same_v<T, std::chrono::sys_seconds>) {
    return FieldKind::WallTime;
  } else if constexpr (std::is_void_v<typename Traits::Element>) {
    return FieldKind::Number;
  } else if constexpr (kind_of<typename Traits::Element>() == FieldKind::Number) {
    return FieldKind::Numbers;
  } else if constexpr (kind_of<typename Traits::Element>() == FieldKind::Whole) {
    return FieldKind::Wholes;
  } else if constexpr (kind_of<typename Traits::Element>() == FieldKind::Pair) {
    return FieldKind::Matrix;
  } else {
    return FieldKind::Texts;
  }
}

/// Columns of a member's matrix; a list of pairs has two.
template <class T>
constexpr std::size_t columns_of() {
  using Traits = SlotTraits<T>;
  if constexpr (Traits::is_optional) {
    return columns_of<typename Traits::Element>();
  } else if constexpr (kind_of<T>() == FieldKind::Matrix && !Traits::is_matrix) {
    return 2;
  } else {
    return Traits::kColumns;
  }
}

/// Numbers of a matrix, row by row.
template <class M>
void put_matrix(M& slot, const std::vector<double>& numbers) {
  if constexpr (M::SizeAtCompileTime == Eigen::Dynamic) {
    Eigen::Index n = 0;
    while (n * n < static_cast<Eigen::Index>(numbers.size())) ++n;
    slot.resize(n, n);
  }
  for (Eigen::Index i = 0; i < slot.size(); ++i) {
    slot(i / slot.cols(), i % slot.cols()) = numbers[static_cast<std::size_t>(i)];
  }
}
template <class M>
void get_matrix(const M& slot, std::vector<double>& numbers) {
  for (Eigen::Index i = 0; i < slot.size(); ++i) {
    numbers.push_back(slot(i / slot.cols(), i % slot.cols()));
  }
}

/// Puts a value into a member.
template <class T>
void put(T& slot, const FieldValue& value) {
  using Traits = SlotTraits<T>;
  constexpr FieldKind kKind = kind_of<T>();
  if constexpr (Traits::is_optional) {
    slot.reset();
    if (!value.is_off) put(slot.emplace(), value);
  } else if constexpr (kKind == FieldKind::Truth) {
    slot = value.truth;
  } else if constexpr (kKind == FieldKind::Whole) {
    slot = static_cast<T>(value.whole);
  } else if constexpr (Traits::is_matrix) {
    put_matrix(slot, value.numbers);
  } else if constexpr (Traits::is_place) {
    slot = Traits::of(value.numbers[0], value.numbers[1]);
  } else if constexpr (kKind == FieldKind::Text) {
    slot = value.text;
  } else if constexpr (kKind == FieldKind::File) {
    slot = value.folder / value.text;
  } else if constexpr (kKind == FieldKind::WallTime) {
    slot = value.time;
  } else if constexpr (kKind == FieldKind::Number && std::is_void_v<typename Traits::Dimension>) {
    slot = value.number;
  } else if constexpr (kKind == FieldKind::Number) {
    slot = make_quantity<typename Traits::Dimension>(value.number);
  } else if constexpr (kKind == FieldKind::Numbers) {
    FieldValue one;
    if constexpr (Traits::kRows == 0) slot.resize(value.numbers.size());
    for (std::size_t i = 0; i < slot.size(); ++i) {
      one.number = value.numbers[i];
      one.is_off = std::isnan(one.number);
      put(slot[i], one);
    }
  } else if constexpr (kKind == FieldKind::Wholes) {
    slot.assign(value.wholes.begin(), value.wholes.end());
  } else if constexpr (kKind == FieldKind::Matrix) {
    FieldValue one;
    slot.clear();
    for (std::size_t i = 0; i < value.numbers.size(); i += 2) {
      one.numbers = {value.numbers[i], value.numbers[i + 1]};
      put(slot.emplace_back(), one);
    }
  } else {
    slot.clear();
    for (const std::string& text : value.texts) {
      FieldValue one;
      one.text = text;
      one.folder = value.folder;
      put(slot.emplace_back(), one);
    }
  }
}

/// A value without an upper bound.
inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();
inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// Takes a member's value, for the manual and for files that are written: false if it has none.
template <class T>
bool get(const T& slot, FieldValue& value) {
  using Traits = SlotTraits<T>;
  constexpr FieldKind kKind = kind_of<T>();
  if constexpr (Traits::is_optional) {
    return slot && get(*slot, value);
  } else if constexpr (kKind == FieldKind::Truth) {
    value.truth = slot;
  } else if constexpr (kKind == FieldKind::Whole) {
    value.whole = static_cast<std::int64_t>(slot);
  } else if constexpr (Traits::is_matrix) {
    get_matrix(slot, value.numbers);
  } else if constexpr (Traits::is_place) {
    get_matrix(raw(slot), value.numbers);
  } else if constexpr (kKind == FieldKind::Number && std::is_void_v<typename Traits::Dimension>) {
    value.number = slot;
  } else if constexpr (kKind == FieldKind::Number) {
    value.number = slot / make_quantity<typename Traits::Dimension>(1);
  } else if constexpr (kKind == FieldKind::Numbers) {
    for (const auto& one : slot) {
      const bool is_gap = !get(one, value);
      // A number that is not finite is no gap, and not written as one.
      const bool is_nan = !is_gap && std::isnan(value.number);
      value.numbers.push_back(is_gap ? kNoNumber : is_nan ? kNoLimit : value.number);
    }
    return !slot.empty();
  } else if constexpr (kKind == FieldKind::Wholes) {
    value.wholes.assign(slot.begin(), slot.end());
    return !slot.empty();
  } else if constexpr (kKind == FieldKind::Matrix) {
    for (const auto& one : slot) get(one, value);
  } else if constexpr (kKind == FieldKind::Text) {
    value.text = slot;
    return !slot.empty();
  } else if constexpr (kKind == FieldKind::File) {
    value.text = slot.string();
    return !slot.empty();
  } else if constexpr (kKind == FieldKind::WallTime) {
    value.time = slot;
  } else if constexpr (std::is_same_v<typename Traits::Element, std::string>) {
    value.texts = slot;
  } else {
    return false;
  }
  return true;
}

/// The key's unit. Does not compile if the key ends with none of the dimension's.
template <class D>
constexpr FieldUnit unit_of(std::string_view key) {
  const auto ends = [&](std::string_view end) { return key.ends_with(end); };
  if constexpr (std::is_same_v<D, dimension::Length>) {
    if (ends("_um") || ends("_um_per_day")) {
      return {[](double v) { return um(v).in_mm(); }, [](double v) { return mm(v).in_um(); }};
    }
    if (ends("_mm")) return {};
  } else if constexpr (std::is_same_v<D, dimension::Angle>) {
    if (ends("_deg")) {
      return {[](double v) { return deg(v).in_rad(); }, [](double v) { return rad(v).in_deg(); }};
    }
    if (ends("_mrad")) return {[](double v) { return v * 1e-3; }, [](double v) { return v * 1e3; }};
    if (ends("_urad")) return {[](double v) { return v * 1e-6; }, [](double v) { return v * 1e6; }};
    if (ends("_rad")) return {};
  } else if constexpr (std::is_same_v<D, dimension::Time>) {
    if (ends("_days")) {
      return {[](double v) { return v * 86400; }, [](double v) { return v / 86400; }};
    }
    if (ends("_s")) return {};
  } else if constexpr (std::is_same_v<D, dimension::Feed>) {
    if (ends("_mm_s")) return {};
  } else if constexpr (std::is_same_v<D, dimension::SpindleSpeed>) {
    if (ends("_rpm")) return {};
  } else if constexpr (std::is_same_v<D, dimension::PixelLength>) {
    if (ends("_px")) return {};
  } else {
    return {};
  }
  throw "the key does not end with a unit of its member's dimension";
}

}  // namespace panelcal::internal
