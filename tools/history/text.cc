// SPDX-License-Identifier: Apache-2.0
#include "tools/history/text.h"

#include <cmath>

#include "calib/base/clock.h"
#include "tools/cli/place_text.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

using report::one_line;

std::string number_text(const std::optional<double>& number) {
  return number ? fmt::format("{:.9g}", *number) : "-";
}

std::optional<double> parameter_sigma(const LedgerRecord& record, std::size_t i) {
  const auto k = static_cast<Eigen::Index>(i);
  if (!record.covariance) return std::nullopt;
  return std::sqrt((*record.covariance)(k, k));
}

ParameterChange change_of(const LedgerRecord& before, std::size_t i, const LedgerRecord& after) {
  const LedgerParameter& old = before.parameters[i];
  ParameterChange change{old.name, old.unit, old.value, std::nullopt, std::nullopt};
  const std::optional<std::size_t> j = after.find(old.name);
  if (!j) return change;
  change.after = after.parameters[*j].value;
  const std::optional<double> sigma_before = parameter_sigma(before, i);
  const std::optional<double> sigma_after = parameter_sigma(after, *j);
  if (sigma_before && sigma_after) change.sigma = std::hypot(*sigma_before, *sigma_after);
  return change;
}

}  // namespace

std::optional<double> ParameterChange::change() const {
  if (!before || !after) return std::nullopt;
  return *after - *before;
}

std::string entry_json(const LedgerEntry& entry, bool in_force, const std::string& result) {
  std::string text = ledger_entry_json(entry);
  text.pop_back();
  text += fmt::format(R"(,"hash":"{}","in_force":{},"result":)", entry.hash, in_force);
  bool in_text = false;
  for (std::size_t i = 0; i < result.size(); ++i) {
    const char c = result[i];
    if (in_text && c == '\\') {
      text += c;
      text += result[++i];
      continue;
    }
    if (c == '"') in_text = !in_text;
    if (in_text || (c != '\n' && c != '\r')) text += c;
  }
  return text + "}\n";
}

std::string entry_line(const LedgerEntry& entry, bool in_force) {
  const LedgerRecord& record = entry.record;
  std::string line = fmt::format("{:>5}{} {}  {}  {}  {}  {}",
                                 entry.id,
                                 in_force ? '*' : ' ',
                                 iso_8601(entry.time),
                                 record.key.machine,
                                 word(record.key.kind),
                                 record.key.subject,
                                 word(record.verdict));
  if (entry.restores) line += fmt::format(" to {}", *entry.restores);
  if (!record.reason.empty()) line += ": " + one_line(record.reason);
  return line + "\n";
}

std::string entry_page(const LedgerEntry& entry, bool in_force) {
  const LedgerRecord& record = entry.record;
  std::string page = fmt::format("entry {} of {}{}\n{} of {}, {}\n",
                                 entry.id,
                                 iso_8601(entry.time),
                                 in_force ? ", in force" : "",
                                 word(record.key.kind),
                                 record.key.subject,
                                 record.key.machine);
  page += fmt::format("{}", word(record.verdict));
  if (entry.restores) page += fmt::format(" to entry {}", *entry.restores);
  if (record.replaces) page += fmt::format(", in place of entry {}", *record.replaces);
  page += record.reason.empty() ? "\n" : ": " + one_line(record.reason) + "\n";
  page += fmt::format("asked by {}, with {}\n", record.asked_by, record.software);
  if (record.temperature_degC) page += fmt::format("at {:.4g} degC\n", *record.temperature_degC);
  for (std::size_t i = 0; i < record.parameters.size(); ++i) {
    const LedgerParameter& parameter = record.parameters[i];
    page += fmt::format("  {:<20} {:>16.9g} {}", parameter.name, parameter.value, parameter.unit);
    const std::optional<double> sigma = parameter_sigma(record, i);
    // One of 0 is of what was chosen, not measured.
    page += sigma && *sigma > 0 ? fmt::format("  +- {:.3g}\n", *sigma) : "\n";
  }
  for (const LedgerInput& input : record.inputs) {
    page +=
        fmt::format("  input {}  {} bytes  {}\n", one_line(input.name), input.bytes, input.sha256);
  }
  return page + fmt::format("result {} bytes, sha256 {}\nhash {}\n",
                            entry.result_bytes,
                            entry.result_sha256,
                            entry.hash);
}

Expected<std::vector<ParameterChange>> changes_between(const LedgerEntry& before,
                                                       const LedgerEntry& after,
                                                       const std::string& file) {
  const auto refuse = [&file](std::string what, std::string expected) {
    return failure({Code::LedgerEntryInvalid, {file, 0, 0}, std::move(what), std::move(expected)});
  };
  if (before.record.key.kind != after.record.key.kind) {
    return refuse(fmt::format("entry {} is of {}, entry {} of {}",
                              before.id,
                              word(before.record.key.kind),
                              after.id,
                              word(after.record.key.kind)),
                  "two of one kind");
  }
  std::vector<ParameterChange> changes;
  for (std::size_t i = 0; i < before.record.parameters.size(); ++i) {
    changes.push_back(change_of(before.record, i, after.record));
  }
  for (const LedgerParameter& parameter : after.record.parameters) {
    const std::optional<std::size_t> i = before.record.find(parameter.name);
    if (!i) {
      changes.push_back(
          {parameter.name, parameter.unit, std::nullopt, parameter.value, std::nullopt});
    } else if (before.record.parameters[*i].unit != parameter.unit) {
      return refuse("the unit of " + quoted(std::string_view(parameter.name)) + " differs",
                    "one unit");
    }
  }
  return changes;
}

std::string changes_text(std::span<const ParameterChange> changes) {
  std::string text = fmt::format(
      "{:<20} {:>16} {:>16} {:>14} {:>10}\n", "", "before", "after", "change", "sigmas");
  for (const ParameterChange& c : changes) {
    const std::optional<double> change = c.change();
    const bool has_ratio = change && c.sigma && *c.sigma > 0;
    text += fmt::format("{:<20} {:>16} {:>16} {:>14} {:>10} {}\n",
                        c.name,
                        number_text(c.before),
                        number_text(c.after),
                        change ? fmt::format("{:.4g}", *change) : "-",
                        has_ratio ? fmt::format("{:.1f}", *change / *c.sigma) : "-",
                        c.unit);
  }
  return text;
}

Expected<std::string> series_text(const LedgerSeries& series,
                                  const LedgerKey& key,
                                  const std::string& parameter,
                                  const std::string& file) {
  if (series.points.empty()) {
    return failure({Code::LedgerEntryUnknown,
                    {file, 0, 0},
                    fmt::format("{} {} of {} with {}",
                                word(key.kind),
                                quoted(key.subject),
                                quoted(key.machine),
                                quoted(parameter)),
                    "the name of one of its parameters"});
  }
  std::string text = fmt::format("{} of {} {}, {}, in {}\n",
                                 one_line(parameter),
                                 word(key.kind),
                                 key.subject,
                                 key.machine,
                                 series.unit);
  for (const LedgerSeries::Point& point : series.points) {
    text += fmt::format("{:>5}  {}  {:>16.9g}  {:<12}{}\n",
                        point.id,
                        iso_8601(point.time),
                        point.value,
                        point.sigma ? fmt::format("+- {:.3g}", *point.sigma) : "",
                        word(point.verdict));
  }
  return text;
}

}  // namespace panelcal::history
