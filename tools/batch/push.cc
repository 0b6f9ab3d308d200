// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "calib/base/number_text.h"
#include "tools/batch/results.h"
#include "tools/cli/commands.h"
#include "tools/gather/jobs.h"
#include <fmt/format.h>

namespace panelcal::batch {

Expected<Answer> push(const BatchReportOptions& options, CommandContext& /*context*/) {
  PANELCAL_TRY(Store store, open_results_of(options.results));
  PANELCAL_TRY(gather::JobDelivery delivery, gather::JobDelivery::begin(options.store, store));
  PANELCAL_TRY(const std::int64_t n_jobs, delivery.deliver_all());
  return Answer{
      fmt::format("{} put into {}\n", internal::counted(n_jobs, "job"), delivery.database_name())};
}

}  // namespace panelcal::batch
