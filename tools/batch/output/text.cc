// SPDX-License-Identifier: Apache-2.0
#include <iterator>

#include "calib/base/amount.h"
#include "calib/base/number_text.h"
#include "tools/batch/output/facts.h"
#include <fmt/format.h>

namespace panelcal::batch {
namespace {

using facts::Json;
using internal::grouped;

/// A number of the facts in fixed point; a dash for one that is not known.
std::string shown(const Json& value, int n_decimals) {
  return value.is_number() ? internal::fixed(value.get<double>(), n_decimals) : "-";
}

std::string count_of(const Json& value) {
  return grouped(value.get<std::int64_t>());
}

std::string share(const Json& part, const Json& all) {
  const auto n = all.get<double>();
  return n > 0 ? internal::fixed(100 * part.get<double>() / n, 2) + " %" : "-";
}

void add_errors(std::string& out, const Json& error) {
  if (error.is_null()) return;
  out += fmt::format(
      "errors      rms {} um, predicted {}; largest {} um; chi square {} a coordinate\n",
      shown(error["rms_um"], 3),
      shown(error["predicted_rms_um"], 3),
      shown(error["max_um"], 3),
      internal::fixed(error["chi_square"].get<double>() / (2 * error["n"].get<double>()), 3));
}

void add_table(std::string& out, const Json& rows, std::string_view title) {
  if (rows.empty()) return;
  out += fmt::format("\n{}\n", title);
}

void add_sessions(std::string& out, const Json& sessions) {
  for (const Json& session : sessions) {
    const auto seconds = session["seconds"].get<double>();
    if (seconds <= 0) continue;
    out += fmt::format("started     {}: {} jobs, {} pictures in {} s with {} ({} jobs/s)\n",
                       session["started"].get<std::string>(),
                       count_of(session["n_jobs"]),
                       count_of(session["n_pictures"]),
                       internal::fixed(seconds, 1),
                       amount(session["threads"].get<std::int64_t>(), "thread"),
                       internal::fixed(session["n_jobs"].get<double>() / seconds, 1));
  }
}

void add_tables(std::string& out, const Json& facts) {
  add_table(out, facts["refusals"], "not drilled, by cause");
  for (const Json& row : facts["refusals"]) {
    out += fmt::format("  {:>8}  {:<7} {:<22} {}: {}\n",
                       count_of(row["n_jobs"]),
                       row["state"].get<std::string>(),
                       row["code"].is_null() ? "-" : row["code"].get<std::string>(),
                       row["example_id"].get<std::string>(),
                       row["example"].is_null() ? "" : row["example"].get<std::string>());
  }
  add_table(out,
            facts["conditions"],
            "condition                 jobs  targets     found  error rms  predicted, um");
  for (const Json& row : facts["conditions"]) {
    out += fmt::format("  {:<20} {:>7} {:>8} {:>8} % {:>10} {:>10}\n",
                       row["factor"].get<std::string>() + "=" + row["value"].get<std::string>(),
                       count_of(row["n_jobs"]),
                       count_of(row["n_targets"]),
                       internal::fixed(100 * row["found_rate"].get<double>(), 2),
                       shown(row["error_rms_um"], 3),
                       shown(row["predicted_rms_um"], 3));
  }
  add_table(out,
            facts["worst"],
            "worst targets                              error   residual      sigma, um");
  for (const Json& row : facts["worst"]) {
    out += fmt::format("  {:<28} {:<10} {:>8} {:>10} {:>10}\n",
                       fmt::format("{} #{}", row["id"].get<std::string>(), row["seq"].get<int>()),
                       row["status"].get<std::string>(),
                       shown(row["error_um"], 3),
                       shown(row["residual_um"], 3),
                       shown(row["sigma_um"], 3));
  }
}

}  // namespace

std::string batch_text(const Json& facts) {
  const Json& jobs = facts["jobs"];
  const Json& targets = facts["targets"];
  const Json& fits = facts["fits"];
  std::string out = fmt::format("{} jobs of {}: {} drilled, {} held, {} failed, {} missing\n",
                                count_of(facts["n_jobs"]),
                                facts["manifest"].get<std::string>(),
                                count_of(jobs["drilled"]),
                                count_of(jobs["held"]),
                                count_of(jobs["failed"]),
                                count_of(jobs["missing"]));
  out += fmt::format("targets     {} of {} found ({}), in {} pictures\n",
                     count_of(targets["n_found"]),
                     count_of(targets["n"]),
                     share(targets["n_found"], targets["n"]),
                     count_of(jobs["pictures"]));
  add_errors(out, facts["error"]);
  if (const auto n_spare = fits["degrees_of_freedom"].get<double>(); n_spare > 0) {
    out += fmt::format("fits        {}, chi square {} a degree of freedom\n",
                       count_of(fits["n"]),
                       internal::fixed(fits["chi_square"].get<double>() / n_spare, 3));
  }
  const Json& holes = facts["holes"];
  out += fmt::format("holes       {}, largest shift {} um, largest predicted sigma {} um\n",
                     count_of(holes["n_holes"]),
                     shown(holes["max_shift_um"], 1),
                     shown(holes["max_sigma_um"], 3));
  add_sessions(out, facts["sessions"]);
  add_tables(out, facts);
  return out;
}

}  // namespace panelcal::batch
