// SPDX-License-Identifier: Apache-2.0
#include "machine/check/stated_keys.h"

#include <cstddef>
#include <cstdint>
#include <optional>

#include "calib/base/files/atomic_file.h"
#include "machine/config/machine_config.h"
#include "machine/config/toml/toml_table.h"

namespace panelcal {
namespace {

using KeyPlaces = std::map<std::string, Place, std::less<>>;

std::string row_name(const toml::node& row, std::size_t i_row) {
  const toml::table* const table = row.as_table();
  const auto number = table != nullptr ? (*table)["number"].value<std::int64_t>() : std::nullopt;
  return number ? std::to_string(*number) : std::to_string(i_row);
}

/// Notes a table, or the tables of an array, with all that they hold.
// NOLINTNEXTLINE(misc-no-recursion): parse_toml() bounds how deep tables lie.
void note_keys(const toml::node& node,
               const std::string& name,
               const internal::TomlSource& source,
               KeyPlaces& places) {
  if (!name.empty()) places.emplace(name, source.place(node.source().begin));
  const std::string prefix = name.empty() ? name : name + ".";
  if (const toml::table* const table = node.as_table()) {
    for (const auto& [key, value] : *table) {
      note_keys(value, prefix + std::string(key.str()), source, places);
    }
  } else if (const toml::array* const array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i) {
      const toml::node& row = *array->get(i);
      note_keys(row, prefix + row_name(row, i), source, places);
    }
  }
}

}  // namespace

StatedKeys StatedKeys::of_file(const std::filesystem::path& machine_toml) {
  const Expected<std::string> text = read_file(machine_toml, kMaxConfigBytes);
  return of_text(text ? std::string_view(*text) : std::string_view(), machine_toml);
}

StatedKeys StatedKeys::of_text(std::string_view text, const std::filesystem::path& machine_toml) {
  StatedKeys keys;
  keys.file_ = machine_toml.string();
  const internal::TomlSource source{keys.file_, text};
  if (const auto document = internal::parse_toml(source)) {
    note_keys(*document, "", source, keys.places_);
  }
  return keys;
}

Place StatedKeys::place(std::string_view key) const {
  for (;;) {
    if (const auto found = places_.find(key); found != places_.end()) return found->second;
    const std::size_t dot = key.rfind('.');
    if (dot == std::string_view::npos) return {file_, 0, 0};
    key = key.substr(0, dot);
  }
}

}  // namespace panelcal
