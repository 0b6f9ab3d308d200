// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>

#include "calib/base/fields/field.h"
#include "calib/base/fields/slot_types.h"

// Not installed. Makes a field of a member (calib/base/fields/slot_types.h).
namespace panelcal::internal {

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
  using Traits = SlotTraits<MemberType<Owner, path...>>;
  field.store = store_member<Owner, path...>;
  field.load = load_member<Owner, path...>;
  field.is_optional = Traits::is_optional;
  field.n_rows = Traits::kRows;
  field.n_columns = columns_of<MemberType<Owner, path...>>();
  field.has_gaps = SlotTraits<typename Traits::Element>::is_optional;
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
  if (field.kind != FieldKind::Whole && field.kind != FieldKind::Wholes) {
    throw "not a whole number";
  }
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
/// Numbers whose unit the file states elsewhere, so that their key has none: they are stored as
/// they are written.
template <auto first, auto... more>
constexpr Field plain(std::string_view key, Range range, std::string_view meaning) {
  Field field = panelcal::internal::field<first, more...>(key, meaning);
  field.range = range;
  return field;
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

/// Two whole numbers that go to a member each, of the object at `path`.
template <class Owner, auto x, auto y, auto... path>
constexpr Field count_pair_in(std::string_view key, WholeRange range, std::string_view meaning) {
  Field field = by_rule<Owner>(key, FieldKind::Wholes, meaning);
  field.whole = range;
  field.n_rows = 2;
  field.store = [](void* object, const FieldValue& value) {
    auto& owner = follow(*static_cast<Owner*>(object), path...);
    owner.*x = static_cast<int>(value.wholes[0]);
    owner.*y = static_cast<int>(value.wholes[1]);
    return true;
  };
  field.load = [](const void* object, FieldValue& value) {
    const auto& owner = follow(*static_cast<const Owner*>(object), path...);
    value.wholes = {owner.*x, owner.*y};
    return true;
  };
  return field;
}

/// A time in UTC.
template <auto first, auto... more>
constexpr Field time(std::string_view key, std::string_view meaning) {
  return field<first, more...>(key, meaning).of_kind(FieldKind::Time);
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

/// The same for files that are written too: `name` gives the word.
template <auto parse, auto name, auto first, auto... more>
constexpr Field choice(std::string_view key, std::string_view expected, std::string_view meaning) {
  Field field = word<parse, first, more...>(key, expected, meaning);
  using Owner = typename MemberOf<decltype(first)>::Owner;
  field.load = [](const void* object, FieldValue& value) {
    value.text = name(follow(*static_cast<const Owner*>(object), first, more...));
    return !value.text.empty();
  };
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

/// The same for files that are written too: bool get(const T&, FieldValue&), false if there is
/// none.
template <auto put, auto get>
constexpr Field value_by(std::string_view key,
                         FieldKind kind,
                         std::string_view expected,
                         std::string_view meaning) {
  using Owner = typename ArgumentOf<decltype(put)>::Owner;
  Field field = put_by<put>(key, kind, expected, meaning);
  field.load = [](const void* object, FieldValue& value) {
    return get(*static_cast<const Owner*>(object), value);
  };
  return field;
}

/// A text, in quotes here, that is always the same.
template <class Owner>
constexpr Field constant(std::string_view key, std::string_view text, std::string_view meaning) {
  Field field = by_rule<Owner>(key, FieldKind::Word, meaning);
  field.expected = text;
  return field;
}

/// A key that a line may have, and that this reader does not need.
template <class Owner>
constexpr Field ignored(std::string_view key) {
  return by_rule<Owner>(key, FieldKind::Any, "").or_absent();
}

/// The first two keys of every file: what it is, in quotes here, and the version of its form.
template <class Owner>
constexpr std::array<Field, 2> head_of(std::string_view kind, int version) {
  Field number = by_rule<Owner>("version", FieldKind::Whole, "of the form of such files");
  number.whole = {version, version};
  return {constant<Owner>("kind", kind, "the kind of file"), number};
}

template <class M>
concept IsList = requires(M& list) {
  list.emplace_back();
};

/// Objects in a member: itself, an optional one, or a list.
template <class Owner, auto... path>
constexpr InnerObjects inner_objects() {
  using Member = MemberType<Owner, path...>;
  InnerObjects inner;
  inner.open = [](void* object) -> void* {
    Member& member = follow(*static_cast<Owner*>(object), path...);
    if constexpr (SlotTraits<Member>::is_optional || IsList<Member>) {
      if constexpr (IsList<Member>) return &member.emplace_back();
      if constexpr (SlotTraits<Member>::is_optional) return &member.emplace();
    } else {
      return &member;
    }
  };
  inner.count = [](const void* object) -> std::size_t {
    const Member& member = follow(*static_cast<const Owner*>(object), path...);
    if constexpr (IsList<Member>) return member.size();
    if constexpr (SlotTraits<Member>::is_optional) return member.has_value() ? 1 : 0;
    return 1;
  };
  inner.at = [](const void* object, [[maybe_unused]] std::size_t i) -> const void* {
    const Member& member = follow(*static_cast<const Owner*>(object), path...);
    if constexpr (IsList<Member>) {
      return &member[i];
    } else if constexpr (SlotTraits<Member>::is_optional) {
      return &*member;
    } else {
      return &member;
    }
  };
  return inner;
}

/// An object in a member, an optional one, or a list of them: rows of `table`.
template <const auto& table, auto first, auto... more>
constexpr Field inner(std::string_view key, std::string_view meaning) {
  using Owner = typename MemberOf<decltype(first)>::Owner;
  using Member = MemberType<Owner, first, more...>;
  Field field =
      by_rule<Owner>(key, IsList<Member> ? FieldKind::Objects : FieldKind::Object, meaning);
  field.inner = inner_objects<Owner, first, more...>();
  field.is_optional = SlotTraits<Member>::is_optional;
  field.table = &table;
  return field;
}

/// An object whose values go into the same object as those beside it.
template <const auto& table, class Owner>
constexpr Field inner_part(std::string_view key, std::string_view meaning) {
  Field field = by_rule<Owner>(key, FieldKind::Object, meaning);
  field.inner = {[](void* object) { return object; },
                 [](const void*) -> std::size_t { return 1; },
                 [](const void* object, std::size_t) { return object; }};
  field.table = &table;
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
