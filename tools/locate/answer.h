// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/json/facts.h"
#include "tools/cli/commands.h"

namespace panelcal::internal {

/// States what became of the pictures: share/schema/locate.schema.json.
///
/// In     pictures: rows of tools/locate/located_json.h; log: of what could not be read or written;
///        text: the rest for standard output
Answer locate_answer(const LocateCommandOptions& options,
                     CommandContext& context,
                     const facts::Json& pictures,
                     const DiagnosticLog& log,
                     std::string text = {});

}  // namespace panelcal::internal
