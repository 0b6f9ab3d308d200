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

/// One member type: the kind of its keys, and how a value gets in and out.
template <class T>
struct Slot;

template <FieldKind the_kind>
struct SlotOf {
  static constexpr FieldKind kind = the_kind;
};

template <>
struct Slot<bool> : SlotOf<FieldKind::Truth> {
  static void put(bool& slot, const FieldValue& value) { slot = value.truth; }
  static bool get(bool slot, FieldValue& value) {
    value.truth = slot;
    return true;
  }
};

template <class T>
requires std::is_integral_v<T>
struct Slot<T> : SlotOf<FieldKind::Whole> {
  static void put(T& slot, const FieldValue& value) { slot = static_cast<T>(value.whole); }
  static bool get(T slot, FieldValue& value) {
    value.whole = static_cast<std::int64_t>(slot);
    return true;
  }
};

template <>
struct Slot<double> : SlotOf<FieldKind::Number> {
  static void put(double& slot, const FieldValue& value) { slot = value.number; }
  static bool get(double slot, FieldValue& value) {
    value.number = slot;
    return true;
  }
};

template <class D>
struct Slot<Quantity<D>> : SlotOf<FieldKind::Number> {
  static void put(Quantity<D>& slot, const FieldValue& value) {
    slot = make_quantity<D>(value.number);
  }
  static bool get(Quantity<D> slot, FieldValue& value) {
    value.number = slot / make_quantity<D>(1);
    return true;
  }
};

template <>
struct Slot<Eigen::Vector2d> : SlotOf<FieldKind::Pair> {
  static void put(Eigen::Vector2d& slot, const FieldValue& value) {
    slot = {value.numbers[0], value.numbers[1]};
  }
  static bool get(const Eigen::Vector2d& slot, FieldValue& value) {
    value.numbers = {slot.x(), slot.y()};
    return true;
  }
};

template <class F>
struct Slot<Position<F>> : SlotOf<FieldKind::Pair> {
  static void put(Position<F>& slot, const FieldValue& value) {
    slot = position_mm<F>(value.numbers[0], value.numbers[1]);
  }
  static bool get(const Position<F>& slot, FieldValue& value) {
    return Slot<Eigen::Vector2d>::get(slot.in_mm(), value);
  }
};

template <class F>
struct Slot<Displacement<F>> : SlotOf<FieldKind::Pair> {
  static void put(Displacement<F>& slot, const FieldValue& value) {
    slot = displacement_mm<F>(value.numbers[0], value.numbers[1]);
  }
  static bool get(const Displacement<F>& slot, FieldValue& value) {
    return Slot<Eigen::Vector2d>::get(slot.in_mm(), value);
  }
};

template <>
struct Slot<std::vector<double>> : SlotOf<FieldKind::Numbers> {
  static void put(std::vector<double>& slot, const FieldValue& value) { slot = value.numbers; }
  static bool get(const std::vector<double>& slot, FieldValue& value) {
    value.numbers = slot;
    return !slot.empty();
  }
};

template <>
struct Slot<std::vector<Length>> : SlotOf<FieldKind::Numbers> {
  static void put(std::vector<Length>& slot, const FieldValue& value) {
    slot.clear();
    for (const double one_mm : value.numbers) slot.push_back(mm(one_mm));
  }
  static bool get(const std::vector<Length>& slot, FieldValue& value) {
    for (const Length one : slot) value.numbers.push_back(one.in_mm());
    return !slot.empty();
  }
};

template <>
struct Slot<std::string> : SlotOf<FieldKind::Text> {
  static void put(std::string& slot, const FieldValue& value) { slot = value.text; }
  static bool get(const std::string& slot, FieldValue& value) {
    value.text = slot;
    return !slot.empty();
  }
};

template <>
struct Slot<std::filesystem::path> : SlotOf<FieldKind::File> {
  static void put(std::filesystem::path& slot, const FieldValue& value) {
    slot = value.folder / value.text;
  }
  static bool get(const std::filesystem::path& slot, FieldValue& value) {
    value.text = slot.string();
    return !slot.empty();
  }
};

template <>
struct Slot<std::vector<std::string>> : SlotOf<FieldKind::Texts> {
  static void put(std::vector<std::string>& slot, const FieldValue& value) { slot = value.texts; }
  static bool get(const std::vector<std::string>& slot, FieldValue& value) {
    value.texts = slot;
    return !slot.empty();
  }
};

template <>
struct Slot<std::vector<std::filesystem::path>> : SlotOf<FieldKind::Texts> {
  static void put(std::vector<std::filesystem::path>& slot, const FieldValue& value) {
    slot.clear();
    for (const std::string& name : value.texts) slot.push_back(value.folder / name);
  }
  static bool get(const std::vector<std::filesystem::path>& slot, FieldValue& value) {
    for (const std::filesystem::path& one : slot) value.texts.push_back(one.string());
    return !slot.empty();
  }
};

template <>
struct Slot<std::chrono::sys_seconds> : SlotOf<FieldKind::WallTime> {
  static void put(std::chrono::sys_seconds& slot, const FieldValue& value) { slot = value.time; }
  static bool get(std::chrono::sys_seconds slot, FieldValue& value) {
    value.time = slot;
    return slot != std::chrono::sys_seconds();
  }
};

template <class T>
struct Slot<std::optional<T>> : SlotOf<Slot<T>::kind> {
  static void put(std::optional<T>& slot, const FieldValue& value) {
    slot.reset();
    if (!value.is_off) Slot<T>::put(slot.emplace(), value);
  }
  static bool get(const std::optional<T>& slot, FieldValue& value) {
    return slot && Slot<T>::get(*slot, value);
  }
};

/// What a member holds a unit of; void: a bare number, a text and so on.
template <class T>
struct DimensionOf {
  using Type = void;
};
template <class D>
struct DimensionOf<Quantity<D>> {
  using Type = D;
};
template <class F>
struct DimensionOf<Position<F>> {
  using Type = dimension::Length;
};
template <class F>
struct DimensionOf<Displacement<F>> {
  using Type = dimension::Length;
};
template <class T>
struct DimensionOf<std::optional<T>> : DimensionOf<T> {};
template <class T>
struct DimensionOf<std::vector<T>> : DimensionOf<T> {};

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
  Slot<MemberType<Owner, path...>>::put(follow(*static_cast<Owner*>(object), path...), value);
  return true;
}

template <class Owner, auto... path>
bool load_member(const void* object, FieldValue& value) {
  return Slot<MemberType<Owner, path...>>::get(follow(*static_cast<const Owner*>(object), path...),
                                               value);
}

/// A text, a truth, a list of texts, a time: what has no range.
template <class Owner, auto... path>
constexpr Field field_in(std::string_view key, std::string_view meaning) {
  Field field;
  field.key = key;
  field.kind = Slot<MemberType<Owner, path...>>::kind;
  field.meaning = meaning;
  field.store = store_member<Owner, path...>;
  field.load = load_member<Owner, path...>;
  field.owner = &kOwner<Owner>;
  return field;
}

/// A number, two or several; the range is that of each.
template <class Owner, auto... path>
constexpr Field field_in(std::string_view key, Range range, std::string_view meaning) {
  Field field = field_in<Owner, path...>(key, meaning);
  if (field.kind == FieldKind::Whole) throw "a whole number has a WholeRange";
  field.range = range;
  field.unit = unit_of<typename DimensionOf<MemberType<Owner, path...>>::Type>(key);
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
  Slot<MemberType<Owner, x>>::put(owner.*x, one);
  one.number = value.numbers[1];
  Slot<MemberType<Owner, y>>::put(owner.*y, one);
  return true;
}

template <class Owner, auto x, auto y>
bool load_pair(const void* object, FieldValue& value) {
  const Owner& owner = *static_cast<const Owner*>(object);
  for (const bool is_y : {false, true}) {
    FieldValue one;
    const bool has = is_y ? Slot<MemberType<Owner, y>>::get(owner.*y, one)
                          : Slot<MemberType<Owner, x>>::get(owner.*x, one);
    if (!has) return false;
    value.numbers.push_back(one.number);
  }
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
  Field field;
  field.key = key;
  field.kind = FieldKind::Word;
  field.expected = expected;
  field.meaning = meaning;
  field.store = store_word<parse, Owner, first, more...>;
  field.owner = &kOwner<Owner>;
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
  Field field;
  field.key = key;
  field.kind = kind;
  field.expected = expected;
  field.meaning = meaning;
  field.store = [](void* object, const FieldValue& value) {
    return put(*static_cast<Owner*>(object), value);
  };
  field.owner = &kOwner<Owner>;
  return field;
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
