// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

#include "calib/base/files/atomic_file.h"
#include <nlohmann/json.hpp>

#include "tests/support/folders.h"

namespace panelcal::test {

/// True if a value is of a JSON Schema type.
inline bool is_of_type(const nlohmann::json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "boolean") return value.is_boolean();
  return type == "null" && value.is_null();
}

/// The first place where a value is not as a schema says, as far as screen.schema.json uses JSON
/// Schema; empty if there is none.
inline std::string schema_problem(const nlohmann::json& schema,
                                  const nlohmann::json& value,
                                  const std::string& place = "") {
  if (schema.contains("const") && schema["const"] != value) return place + ": " + value.dump();
  if (schema.contains("enum") && std::ranges::find(schema["enum"], value) == schema["enum"].end()) {
    return place + ": " + value.dump();
  }
  if (schema.contains("type")) {
    const nlohmann::json types =
        schema["type"].is_array() ? schema["type"] : nlohmann::json::array({schema["type"]});
    const bool is_one = std::ranges::any_of(
        types, [&](const nlohmann::json& type) { return is_of_type(value, type); });
    if (!is_one) return place + ": " + value.dump() + " is no " + schema["type"].dump();
  }
  if (value.is_number() && value < schema.value("minimum", value.get<double>())) {
    return place + ": " + value.dump();
  }
  if (value.is_object()) {
    for (const auto& key : schema.value("required", nlohmann::json::array())) {
      if (!value.contains(key.get<std::string>())) return place + " lacks " + key.dump();
    }
    const nlohmann::json properties = schema.value("properties", nlohmann::json::object());
    for (const auto& [key, member] : value.items()) {
      const nlohmann::json rest = schema.value("additionalProperties", nlohmann::json(true));
      const bool is_named = properties.contains(key);
      if (!is_named && rest == false) return place + " has " + key;
      const nlohmann::json& of_member = is_named ? properties[key] : rest;
      if (!of_member.is_object()) continue;
      const std::string problem = schema_problem(of_member, member, place + "/" + key);
      if (!problem.empty()) return problem;
    }
  }
  if (value.is_array()) {
    const auto n = static_cast<int>(value.size());
    if (n < schema.value("minItems", n) || n > schema.value("maxItems", n)) {
      return place + " has " + std::to_string(n) + " items";
    }
    for (const auto& item : value) {
      if (!schema.contains("items")) break;
      const std::string problem = schema_problem(schema["items"], item, place + "/*");
      if (!problem.empty()) return problem;
    }
  }
  return "";
}

/// The same of the document that a screen shows.
inline std::string screen_problem(const nlohmann::json& screen) {
  static const nlohmann::json schema = nlohmann::json::parse(
      read_file(source_folder() / "share/schema/screen.schema.json").value_or("false"));
  return schema_problem(schema, screen);
}

}  // namespace panelcal::test
