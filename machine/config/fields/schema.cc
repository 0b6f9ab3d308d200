// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string_view>

#include "machine/config/fields/page.h"
#include <nlohmann/json.hpp>

namespace panelcal::internal {
namespace {

using Json = nlohmann::ordered_json;

Json number_schema(const Range& range) {
  Json json = {{"type", "number"}};
  if (std::isfinite(range.low))
    json[range.low_is_open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) json["maximum"] = range.high;
  return json;
}

/// The texts in quotes: `"bright" or "dark"`.
Json words_of(std::string_view expected) {
  Json words = Json::array();
  for (auto open = expected.find('"'); open != expected.npos; open = expected.find('"', open + 1)) {
    const std::size_t begin = open + 1;
    open = expected.find('"', begin);
    words.push_back(expected.substr(begin, open - begin));
  }
  return words;
}

Json value_schema(const Field& field) {
  switch (field.kind) {
    case FieldKind::Truth:
      return {{"type", "boolean"}};
    case FieldKind::Whole:
      return {{"type", "integer"}, {"minimum", field.whole.low}, {"maximum", field.whole.high}};
    case FieldKind::Number:
      return number_schema(field.range);
    case FieldKind::Limit:
      return {{"anyOf", {number_schema(field.range), Json{{"const", "off"}}}}};
    case FieldKind::Pair:
      return {{"type", "array"},
              {"items", number_schema(field.range)},
              {"minItems", 2},
              {"maxItems", 2}};
    case FieldKind::Numbers:
      return {{"type", "array"}, {"items", number_schema(field.range)}};
    case FieldKind::Word:
      return {{"type", "string"}, {"enum", words_of(field.expected)}};
    case FieldKind::Text:
    case FieldKind::Form:
      return {{"type", "string"}, {"minLength", field.expected.empty() ? 0 : 1}};
    case FieldKind::File:
    case FieldKind::Folder:
      return {{"type", "string"}, {"minLength", 1}};
    case FieldKind::Texts:
      return {{"type", "array"}, {"items", {{"type", "string"}}}};
    case FieldKind::WallTime:
      return Json::object();  // JSON has no dates
  }
  return Json::object();
}

Json field_schema(const TableDescription& table, const Field& field) {
  Json json = value_schema(field);
  json["description"] = field.meaning;
  const bool is_stated = field.absence.empty() && !field.is_required();
  const std::string initial = is_stated ? table.initial_text(field) : std::string();
  if (!initial.empty()) json["default"] = Json::parse(initial);
  return json;
}

/// A key that a table must have, and its alternative.
void require(const Field& field, Json& json) {
  if (!field.is_required()) return;
  if (field.alternative.empty()) {
    json["required"].push_back(field.key);
    return;
  }
  json["anyOf"] = {Json{{"required", {field.key}}}, Json{{"required", {field.alternative}}}};
}

/// The table of a name, with those that lie in it; with an empty name the file.
// NOLINTNEXTLINE(misc-no-recursion): tables lie in each other three deep.
Json table_schema(const FileDescription& file, std::string_view name) {
  Json json = {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
  for (const TableDescription* const table : file.tables) {
    if (table->name == name) {
      if (!table->about.empty()) json["description"] = table->about;
      for (const Field& field : table->fields) {
        json["properties"][std::string(field.key)] = field_schema(*table, field);
        require(field, json);
      }
    } else if (table->parent() == name) {
      const Json child = table_schema(file, table->name);
      json["properties"][std::string(table->key())] =
          table->rows == Rows::One ? child : Json{{"type", "array"}, {"items", child}};
    }
  }
  return json;
}

}  // namespace

std::string schema_of(const FileDescription& file) {
  Json json = {{"$schema", "http://json-schema.org/draft-07/schema#"},
               {"title", std::string(file.name) + " of panelcal"}};
  json.update(table_schema(file, ""));
  return json.dump(2) + "\n";
}

}  // namespace panelcal::internal
