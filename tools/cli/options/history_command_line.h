// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/cli/options/history_options.h"

namespace CLI {
class App;
}

namespace panelcal {

/// Adds what `panelcal history` understands; `options` must outlive `history`.
void add_history_commands(CLI::App& history, HistoryOptions& options);

}  // namespace panelcal
