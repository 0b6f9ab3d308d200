// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/fields/field.h"
#include "calib/base/fields/json_file.h"

// Not installed.
namespace panelcal::internal {

/// The tables of a file with all of their keys, in Markdown: a heading and a list of keys each.
///
/// See    docs/formats/machine_toml.md
std::string page_of(const FileDescription& file);

/// The same as a JSON Schema (draft 7), for editors.
///
/// See    share/schema/machine.schema.json; tests/tools/machine_schema_test.py
std::string schema_of(const FileDescription& file);

/// The same of a JSON file: all keys of each of its versions, those of objects in it behind a dot.
///
/// See    docs/formats/json_files.md
std::string page_of(const JsonFile& file);
/// See    share/schema/, one schema a file; tests/tools/json_schema_test.py
std::string schema_of(const JsonFile& file);

}  // namespace panelcal::internal
