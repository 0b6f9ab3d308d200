// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string_view>
#include <utility>

#include "calib/base/fields/noted_head.h"
#include "calib/base/fields/page.h"
#include <nlohmann/json.hpp>

namespace panelcal::internal {
namespace {

using Json = nlohmann::ordered_json;

Json number_schema(const Range& range) {
  Json schema = {{"type", "number"}};
  if (std::isfinite(range.low))
    schema[range.low_is_open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) schema["maximum"] = range.high;
  return schema;
}

/// The texts in quotes: `"bright" or "dark"`.
Json listed_words(std::string_view expected) {
  Json words = Json::array();
  for (auto open = expected.find('"'); open != expected.npos; open = expected.find('"', open + 1)) {
    const std::size_t begin = open + 1;
    open = expected.find('"', begin);
    words.push_back(expected.substr(begin, open - begin));
  }
  return words;
}

Json or_null(const Json& schema) {
  return {{"anyOf", {schema, Json{{"type", "null"}}}}};
}

Json whole_schema(const Field& field) {
  return {{"type", "integer"}, {"minimum", field.whole.low}, {"maximum", field.whole.high}};
}

/// A list of n elements; n = 0: of any number.
Json list_schema(Json items, std::size_t n) {
  Json schema = {{"type", "array"}, {"items", std::move(items)}};
  if (n > 0) schema.update({{"minItems", n}, {"maxItems", n}});
  return schema;
}

// NOLINTNEXTLINE(misc-no-recursion): objects lie in each other four deep.
Json object_schema(const TableDescription& table);

// NOLINTNEXTLINE(misc-no-recursion): as above.
Json value_schema(const Field& field) {
  switch (field.kind) {
    case FieldKind::Truth:
      return {{"type", "boolean"}};
    case FieldKind::Whole:
      return whole_schema(field);
    case FieldKind::Counter:
      return {{"type", "integer"}, {"minimum", 0}};
    case FieldKind::Wholes:
      return list_schema(whole_schema(field), field.n_rows);
    case FieldKind::Matrix:
      return list_schema(list_schema(number_schema(field.range), field.n_columns), field.n_rows);
    case FieldKind::Object:
      return object_schema(*field.table);
    case FieldKind::Objects: {
      const Json one = object_schema(*field.table);
      const Json list = list_schema(one, 0);
      return field.is_alone_plain ? Json{{"anyOf", {one, list}}} : list;
    }
    case FieldKind::Number:
      return number_schema(field.range);
    case FieldKind::Limit:
      return {{"anyOf", {number_schema(field.range), Json{{"const", "off"}}}}};
    case FieldKind::Pair:
      return list_schema(number_schema(field.range), 2);
    case FieldKind::Numbers: {
      const Json number = number_schema(field.range);
      return list_schema(field.has_gaps ? or_null(number) : number, field.n_rows);
    }
    case FieldKind::Word:
      return {{"type", "string"}, {"enum", listed_words(field.expected)}};
    case FieldKind::Text:
    case FieldKind::Form:
      return {{"type", "string"}, {"minLength", field.expected.empty() ? 0 : 1}};
    case FieldKind::File:
    case FieldKind::Folder:
      return {{"type", "string"}, {"minLength", 1}};
    case FieldKind::Texts:
      return list_schema({{"type", "string"}}, field.n_rows);
    case FieldKind::Time:
      return {{"type", "string"}, {"minLength", 20}};
    case FieldKind::Any:
    case FieldKind::WallTime:
      return Json::object();  // JSON has no dates
  }
  return Json::object();
}

Json field_schema(const TableDescription& table, const Field& field) {
  Json schema = value_schema(field);
  schema["description"] = field.meaning;
  const bool is_stated = field.absence.empty() && !field.is_required();
  const std::string initial = is_stated ? table.initial_text(field) : std::string();
  if (!initial.empty()) schema["default"] = Json::parse(initial);
  return schema;
}

/// A key that a table must have, and its alternative.
void require(const Field& field, Json& schema) {
  if (!field.is_required()) return;
  if (field.alternative.empty()) {
    schema["required"].push_back(field.key);
    return;
  }
  schema["anyOf"] = {Json{{"required", {field.key}}}, Json{{"required", {field.alternative}}}};
}

/// The table of a name, with those that lie in it; with an empty name the file.
// NOLINTNEXTLINE(misc-no-recursion): tables lie in each other three deep.
Json table_schema(const FileDescription& file, std::string_view name) {
  Json schema = {
      {"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
  for (const TableDescription* const table : file.tables) {
    if (table->name == name) {
      if (!table->about.empty()) schema["description"] = table->about;
      for (const Field& field : table->fields) {
        schema["properties"][std::string(field.key)] = field_schema(*table, field);
        require(field, schema);
      }
    } else if (table->parent() == name) {
      const Json child = table_schema(file, table->name);
      schema["properties"][std::string(table->key())] =
          table->rows == Rows::One ? child : Json{{"type", "array"}, {"items", child}};
    }
  }
  return schema;
}

// NOLINTNEXTLINE(misc-no-recursion): as above.
Json object_schema(const TableDescription& table) {
  Json schema = {{"type", "object"},
                 {"additionalProperties", false},
                 {"required", Json::array()},
                 {"properties", Json::object()}};
  for (const Field& field : table.fields) {
    const Json value = value_schema(field);
    Json& property = schema["properties"][std::string(field.key)];
    property = field.is_optional && !field.may_lack ? or_null(value) : value;
    if (!field.meaning.empty()) property["description"] = field.meaning;
    if (!field.may_lack) schema["required"].push_back(field.key);
  }
  return schema;
}

}  // namespace

std::string schema_of(const JsonFile& file) {
  Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                 {"title", std::string(file.name) + " of panelcal"},
                 {"anyOf", Json::array()}};
  for (const TableDescription* const version : file.versions) {
    Json form = object_schema(*version);
    for (const TableDescription* const note : noted_head_tables()) {
      if (file.notes_ledger) form["properties"]["ledger"]["anyOf"].push_back(object_schema(*note));
    }
    schema["anyOf"].push_back(std::move(form));
  }
  return schema.dump(2) + "\n";
}

std::string schema_of(const FileDescription& file) {
  Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                 {"title", std::string(file.name) + " of panelcal"}};
  schema.update(table_schema(file, ""));
  return schema.dump(2) + "\n";
}

}  // namespace panelcal::internal
