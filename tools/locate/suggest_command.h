// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/cli/commands.h"

namespace panelcal::internal {

/// `panelcal locate --suggest`.
Expected<Answer> suggest(const LocateCommandOptions& options, CommandContext& context);

}  // namespace panelcal::internal
