// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of reading a TOML file.
namespace panelcal::internal {

/// Completes the refusal of a table that lacks keys by what all other tables of the file lack, so
/// that a user need not run once for each.
///
/// Out    problem as it is if it is not of a table that lacks a required key, or of the only one
/// See    tests/machine/config/toml/missing_keys_test.cc
Diagnostic with_all_missing_keys(Diagnostic problem,
                                 const toml::table& document,
                                 const FileDescription& file,
                                 const TomlSource& source);

}  // namespace panelcal::internal
