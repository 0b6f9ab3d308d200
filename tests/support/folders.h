// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace panelcal::test {

/// The clone that the tests were built from.
///
/// One unit alone knows the path, so that a compiler cache serves all other units of another clone.
std::filesystem::path source_folder();

}  // namespace panelcal::test
