// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "machine/config/fields/field.h"
#include <Eigen/Core>

// Not installed. Makes a field of a member: the member's type tells what the key takes, and the
// key's end the unit, which has to be one of the type's.
namespace panelcal::internal {

template <class T>
struct SlotTraits {
  using Dimension = void;  ///< of its values; void: a bare number, a text and so on
  using Element = void;    ///< of an optional or a list
  static constexpr bool is_optional = false;
  static constexpr bool is_place = false;
};
template <class D>
struct SlotTraits<Quantity<D>> : SlotTraits<void> {
  using Dimension = D;
};
template <class F>
struct SlotTraits<Position<F>> : SlotTraits<void> {
  using Dimension = dimension::Length;
  static constexpr bool is_place = true;
  static Position<F> of(double x_mm, double y_mm) { return position_mm<F>(x_mm, y_mm); }
};
template <class F>
struct SlotTraits<Displacement<F>> : SlotTraits<void> {
  using Dimension = dimension::Length;
  static constexpr bool is_place = true;
  static Displacement<F> of(double x_mm, double y_mm) { return displacement_mm<F>(x_mm, y_mm); }
};
template <class T>
struct SlotTraits<std::optional<T>> : SlotTraits<void> {
  using Dimension = typename SlotTraits<T>::Dimension;
  using Element = T;
  static constexpr bool is_optional = true;
};
template <class T>
struct SlotTraits<std::vector<T>> : SlotTraits<void> {
  using Dimension = typename SlotTraits<T>::Dimension;
  using Element = T;
};

/// The values that a member of this type takes.
template <class T>
constexpr FieldKind kind_of() {
  using Traits = SlotTraits<T>;
  if constexpr (Traits::is_optional) {
    return kind_of<typename Traits::Element>();
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
  } else {
    return FieldKind::Texts;
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
  } else if constexpr (Traits::is_place) {
    slot = Traits::of(value.numbers[0], value.numbers[1]);
  } else if constexpr (kKind == FieldKind::Pair) {
    slot = {value.numbers[0], value.numbers[1]};
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
    slot.clear();
    for (const double number : value.numbers) {
      one.number = number;
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

/// Takes a member's value, for the manual: false if it has none.
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
  } else if constexpr (Traits::is_place) {
    value.numbers = {slot.in_mm().x(), slot.in_mm().y()};
  } else if constexpr (kKind == FieldKind::Pair) {
    value.numbers = {slot.x(), slot.y()};
  } else if constexpr (kKind == FieldKind::Number && std::is_void_v<typename Traits::Dimension>) {
    value.number = slot;
  } else if constexpr (kKind == FieldKind::Number) {
    value.number = slot / make_quantity<typename Traits::Dimension>(1);
  } else if constexpr (kKind == FieldKind::Numbers) {
    for (const auto& one : slot) {
      get(one, value);
      value.numbers.push_back(value.number);
    }
    return !slot.empty();
  } else if constexpr (kKind == FieldKind::Text || kKind == FieldKind::File) {
    value.text = std::filesystem::path(slot).string();
    return !slot.empty();
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
    if (ends("_um") || ends("_um_per_day")) return {[](double v) { return um(v).in_mm(); }};
    if (ends("_mm")) return {[](double v) { return v; }};
  } else if constexpr (std::is_same_v<D, dimension::Angle>) {
    if (ends("_deg")) return {[](double v) { return deg(v).in_rad(); }};
    if (ends("_mrad")) return {[](double v) { return v * 1e-3; }};
    if (ends("_urad")) return {[](double v) { return v * 1e-6; }};
  } else if constexpr (std::is_same_v<D, dimension::Time>) {
    if (ends("_days")) return {[](double v) { return v * 86400; }};
    if (ends("_s")) return {[](double v) { return v; }};
  } else if constexpr (std::is_same_v<D, dimension::Feed>) {
    if (ends("_mm_s")) return {[](double v) { return v; }};
  } else if constexpr (std::is_same_v<D, dimension::SpindleSpeed>) {
    if (ends("_rpm")) return {[](double v) { return v; }};
  } else if constexpr (std::is_same_v<D, dimension::PixelLength>) {
    if (ends("_px")) return {[](double v) { return v; }};
  } else {
    return {[](double v) { return v; }};
  }
  throw "the key does not end with a unit of its member's dimension";
}

template <class T>
struct MemberOf;
template <class C, class M>
struct MemberOf<M C::*> {
  using Owner = C;
};

template <class Object>
constexpr auto& follow(Object& object) {
  return object;
}
template <class Object, class Member, class... More>
constexpr auto& follow(Object& object, Member member, More... more) {
  return follow(object.*member, more...);
}

template <class Owner, auto... path>
using MemberType = std::remove_reference_t<decltype(follow(std::declval<Owner&>(), path...))>;

template <class Owner, auto... path>
bool store_member(void* object, const FieldValue& value) {
  put(follow(*static_cast<Owner*>(object), path...), value);
  return true;
}

template <class Owner, auto... path>
bool load_member(const void* object, FieldValue& value) {
  return get(follow(*static_cast<const Owner*>(object), path...), value);
}

/// A key that a rule beside the table reads, since its meaning hangs on other keys.
template <class Owner>
constexpr Field by_rule(std::string_view key, FieldKind kind, std::string_view meaning) {
  Field field;
  field.key = key;
  field.kind = kind;
  field.meaning = meaning;
  field.owner = &kOwner<Owner>;
  return field;
}

/// A text, a truth, a list of texts, a time: what has no range.
template <class Owner, auto... path>
constexpr Field field_in(std::string_view key, std::string_view meaning) {
  Field field = by_rule<Owner>(key, kind_of<MemberType<Owner, path...>>(), meaning);
  field.store = store_member<Owner, path...>;
  field.load = load_member<Owner, path...>;
  return field;
}

/// A number, two or several; the range is that of each.
template <class Owner, auto... path>
constexpr Field field_in(std::string_view key, Range range, std::string_view meaning) {
  Field field = field_in<Owner, path...>(key, meaning);
  if (field.kind == FieldKind::Whole) throw "a whole number has a WholeRange";
  field.range = range;
  field.unit = unit_of<typename SlotTraits<MemberType<Owner, path...>>::Dimension>(key);
  return field;
}

template <class Owner, auto... path>
constexpr Field count_in(std::string_view key, WholeRange range, std::string_view meaning) {
  Field field = field_in<Owner, path...>(key, meaning);
  if (field.kind != FieldKind::Whole) throw "not a whole number";
  field.whole = range;
  return field;
}

/// The same for a member, of a member and so on, whose owner is the table's type itself.
template <auto first, auto... more>
constexpr Field field(std::string_view key, std::string_view meaning) {
  return field_in<typename MemberOf<decltype(first)>::Owner, first, more...>(key, meaning);
}
template <auto first, auto... more>
constexpr Field field(std::string_view key, Range range, std::string_view meaning) {
  return field_in<typename MemberOf<decltype(first)>::Owner, first, more...>(key, range, meaning);
}
template <auto first, auto... more>
constexpr Field count(std::string_view key, WholeRange range, std::string_view meaning) {
  return count_in<typename MemberOf<decltype(first)>::Owner, first, more...>(key, range, meaning);
}

template <class Owner, auto x, auto y>
bool store_pair(void* object, const FieldValue& value) {
  Owner& owner = *static_cast<Owner*>(object);
  FieldValue one;
  one.number = value.numbers[0];
  put(owner.*x, one);
  one.number = value.numbers[1];
  put(owner.*y, one);
  return true;
}

template <class Owner, auto x, auto y>
bool load_pair(const void* object, FieldValue& value) {
  const Owner& owner = *static_cast<const Owner*>(object);
  FieldValue one;
  if (!get(owner.*x, value) || !get(owner.*y, one)) return false;
  value.numbers = {value.number, one.number};
  return true;
}

/// Two numbers, [x, y], that go to a member each.
template <auto x, auto y>
constexpr Field pair(std::string_view key, Range range, std::string_view meaning) {
  using Owner = typename MemberOf<decltype(x)>::Owner;
  Field field = field_in<Owner, x>(key, range, meaning);
  field.kind = FieldKind::Pair;
  field.store = store_pair<Owner, x, y>;
  field.load = load_pair<Owner, x, y>;
  return field;
}

template <auto parse, class Owner, auto... path>
bool store_word(void* object, const FieldValue& value) {
  const auto meant = parse(value.text);
  if (!meant) return false;
  follow(*static_cast<Owner*>(object), path...) = *meant;
  return true;
}

/// One of a few words, which `parse` knows; `expected` names all of them, in quotes.
template <auto parse, auto first, auto... more>
constexpr Field word(std::string_view key, std::string_view expected, std::string_view meaning) {
  using Owner = typename MemberOf<decltype(first)>::Owner;
  Field field = by_rule<Owner>(key, FieldKind::Word, meaning);
  field.expected = expected;
  field.store = store_word<parse, Owner, first, more...>;
  return field;
}

/// A text of a form that `parse` knows.
template <auto parse, auto first, auto... more>
constexpr Field form(std::string_view key, std::string_view expected, std::string_view meaning) {
  Field field = word<parse, first, more...>(key, expected, meaning);
  field.kind = FieldKind::Form;
  return field;
}

template <class F>
struct ArgumentOf;
template <class T>
struct ArgumentOf<bool (*)(T&, const FieldValue&)> {
  using Owner = T;
};

/// A value that a function puts where it belongs: bool put(T&, const FieldValue&), false if it is
/// not as expected.
template <auto put>
constexpr Field put_by(std::string_view key,
                       FieldKind kind,
                       std::string_view expected,
                       std::string_view meaning) {
  using Owner = typename ArgumentOf<decltype(put)>::Owner;
  Field field = by_rule<Owner>(key, kind, meaning);
  field.expected = expected;
  field.store = [](void* object, const FieldValue& value) {
    return put(*static_cast<Owner*>(object), value);
  };
  return field;
}

/// The fields of a table in two parts.
template <std::size_t n, std::size_t m>
constexpr std::array<Field, n + m> joined(const std::array<Field, n>& first,
                                          const std::array<Field, m>& second) {
  std::array<Field, n + m> all;
  for (std::size_t i = 0; i < n; ++i) all[i] = first[i];
  for (std::size_t i = 0; i < m; ++i) all[n + i] = second[i];
  return all;
}

}  // namespace panelcal::internal
