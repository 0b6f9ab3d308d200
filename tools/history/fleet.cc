// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/json/facts.h"
#include "tools/cli/commands.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/stated_clock.h"
#include "tools/gather/address.h"
#include "tools/gather/nights.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using gather::FleetMachine;
using gather::FleetState;

constexpr int kFleetVersion = 1;

facts::Json text_or_null(const std::string& text) {
  return text.empty() ? facts::Json() : facts::Json(text);
}

/// share/schema/fleet.schema.json
facts::Json fleet_facts(const std::vector<FleetMachine>& machines,
                        const std::string& store,
                        std::chrono::sys_seconds time) {
  facts::Json document = facts::envelope("fleet", kFleetVersion);
  document["store"] = store;
  document["time"] = iso_8601(time);
  document["n_may_drill"] = std::ranges::count(machines, FleetState::Drill, &FleetMachine::state);
  document["machines"] = facts::Json::array();
  for (const FleetMachine& one : machines) {
    document["machines"].push_back({{"machine", one.machine},
                                    {"state", name(one.state)},
                                    {"why", one.why},
                                    {"until", text_or_null(one.until)},
                                    {"night", text_or_null(one.night)},
                                    {"finished", text_or_null(one.finished)},
                                    {"outcome", text_or_null(one.outcome)},
                                    {"asked_by", text_or_null(one.asked_by)},
                                    {"n_entries_since", one.n_entries_since},
                                    {"newest_entry", text_or_null(one.newest_entry)},
                                    {"pushed", one.pushed}});
  }
  return document;
}

std::string fleet_text(const std::vector<FleetMachine>& machines) {
  std::size_t width = 0;
  for (const FleetMachine& one : machines) width = std::max(width, one.machine.size());
  std::string text;
  for (const FleetMachine& one : machines) {
    text += fmt::format("{:<8} {:<{}}  {}{}\n",
                        name(one.state),
                        escaped_controls(one.machine),
                        width,
                        one.until.empty() ? "" : "until " + one.until + ": ",
                        escaped_controls(one.why));
  }
  const auto n_drilling = std::ranges::count(machines, FleetState::Drill, &FleetMachine::state);
  return text + fmt::format("{} of {} may drill now\n", n_drilling, machines.size());
}

}  // namespace

Expected<Answer> show_fleet(const HistoryOptions& options, CommandContext& context) {
  PANELCAL_TRY(const Clock clock, stated_clock(options.clock));
  std::error_code ignored;
  if (!gather::is_postgresql(options.store) && !std::filesystem::exists(options.store, ignored)) {
    // If there is none, an empty one would be made, of whose machines all may drill.
    return failure({Code::FileUnreadable,
                    {options.store, 0, 0},
                    "there is no such file",
                    "a database that `panelcal history push` has made"});
  }
  PANELCAL_TRY(const auto database, gather::open_database(options.store));
  const std::chrono::sys_seconds now = clock();
  PANELCAL_TRY(const std::vector<FleetMachine> machines,
               gather::fleet(*database, {now, std::chrono::hours(options.max_age_h)}));
  const bool all_may_drill =
      !machines.empty() && std::ranges::all_of(machines, [](const FleetMachine& one) {
        return one.state == FleetState::Drill;
      });
  return state_facts(context,
                     options.facts,
                     "machines of " + database->name(),
                     [&] { return facts::text(fleet_facts(machines, database->name(), now)); },
                     {fleet_text(machines), all_may_drill ? ExitCode::Done : ExitCode::GateFailed});
}

}  // namespace panelcal::history
