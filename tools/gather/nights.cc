// SPDX-License-Identifier: Apache-2.0
#include "tools/gather/nights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "tools/gather/insertion.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal::gather {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMaxReportBytes = std::size_t{1} << 26;

template <class T>
StoredValue optional_value(const std::optional<T>& value) {
  return value ? StoredValue(*value) : StoredValue();
}

StoredRow entry_row(const std::string& ledger, const LedgerEntry& entry) {
  const LedgerRecord& record = entry.record;
  return {ledger,
          entry.id,
          entry.hash,
          iso_8601(entry.time),
          record.key.machine,
          std::string(word(record.key.kind)),
          record.key.subject,
          std::string(word(record.verdict)),
          record.reason,
          record.asked_by,
          record.software,
          optional_value(record.temperature_degC),
          optional_value(entry.restores)};
}

void add_parameters(const std::string& ledger,
                    const LedgerEntry& entry,
                    std::vector<StoredRow>& rows) {
  const LedgerRecord& record = entry.record;
  for (std::size_t i = 0; i < record.parameters.size(); ++i) {
    const LedgerParameter& parameter = record.parameters[i];
    const auto k = static_cast<Eigen::Index>(i);
    StoredValue sigma;
    if (record.covariance) sigma = std::sqrt((*record.covariance)(k, k));
    rows.push_back({ledger,
                    entry.id,
                    static_cast<std::int64_t>(i),
                    parameter.name,
                    parameter.value,
                    sigma,
                    parameter.unit});
  }
}

/// The number of the last entry that the database has, which the ledger must have too.
Expected<std::int64_t> known_entries(const Ledger& ledger,
                                     const std::string& id,
                                     const std::string& file,
                                     Database& database) {
  const StoredValue values[] = {id};
  PANELCAL_TRY(const std::vector<StoredRow> found,
               database.rows("SELECT n_entries, head_sha256 FROM ledger WHERE id = ?", values));
  if (found.empty()) return 0;
  const std::int64_t n_known = std::get<std::int64_t>(found[0][0]);
  PANELCAL_TRY(const LedgerHead head, ledger.head());
  const auto refuse = [&](const std::string& what) {
    return failure({Code::LedgerCutOff,
                    {file, 0, 0},
                    what,
                    "the ledger that was pushed before, or its newer copy"});
  };
  if (head.id < n_known) {
    return refuse(
        fmt::format("it has {} entries, and {} has {} of it", head.id, database.name(), n_known));
  }
  PANELCAL_TRY(const LedgerEntry last, ledger.entry(n_known));
  if (StoredValue(last.hash) != found[0][1]) {
    return refuse(fmt::format("entry {} differs from that in {}", n_known, database.name()));
  }
  return n_known;
}

Expected<std::int64_t> push_entries(const Ledger& ledger,
                                    const std::string& file,
                                    std::chrono::sys_seconds now,
                                    Database& database) {
  PANELCAL_TRY(const LedgerHead head, ledger.verify());
  if (head.id == 0) return 0;
  PANELCAL_TRY(const LedgerEntry first, ledger.entry(1));
  const std::string& id = first.hash;
  PANELCAL_TRY(const std::int64_t n_known, known_entries(ledger, id, file, database));
  std::vector<StoredRow> entries, parameters;
  PANELCAL_CHECK(ledger.for_each({}, [&](const LedgerEntry& entry) -> Expected<void> {
    if (entry.id > n_known && entry.id <= head.id) {
      entries.push_back(entry_row(id, entry));
      add_parameters(id, entry, parameters);
    }
    return {};
  }));
  const StoredValue values[] = {id, file, head.id, head.hash, iso_8601(now)};
  PANELCAL_CHECK(database.run(
      "INSERT INTO ledger(id, file, n_entries, head_sha256, pushed) VALUES(?,?,?,?,?) ON "
      "CONFLICT(id) DO UPDATE SET file = excluded.file, n_entries = excluded.n_entries, "
      "head_sha256 = excluded.head_sha256, pushed = excluded.pushed",
      values));
  PANELCAL_CHECK(insert(database,
                        "entry",
                        "ledger, number, sha256, time, machine, kind, subject, verdict, reason, "
                        "asked_by, software, temperature_degc, restores",
                        entries));
  PANELCAL_CHECK(
      insert(database, "parameter", "ledger, entry, number, name, value, sigma, unit", parameters));
  return static_cast<std::int64_t>(entries.size());
}

/// A row of table night; empty: the file is no night, or one that moved nothing.
Expected<StoredRow> night_row(const fs::path& file, const std::string& now) {
  PANELCAL_TRY(const std::string text, read_file(file.string(), kMaxReportBytes));
  const json facts = json::parse(text, nullptr, false);
  const auto bad = [&] {
    return failure({Code::Usage,
                    {file.string(), 0, 0},
                    "facts of a night that lack something",
                    "NIGHT.json, as `panelcal nightly` writes it"});
  };
  if (!facts.is_object() || facts.value("facts", json()) != "night") return StoredRow{};
  try {
    if (facts.at("version") != 1) return bad();
    if (facts.at("dry_run").get<bool>()) return StoredRow{};
    const auto word = [&](const char* key) { return facts.at(key).get<std::string>(); };
    StoredValue until;
    if (!facts.at("drill_until").is_null()) until = word("drill_until");
    return StoredRow{word("machine"),
                     word("started"),
                     word("night"),
                     word("finished"),
                     std::int64_t{facts.at("may_drill").get<bool>()},
                     until,
                     word("outcome"),
                     facts.at("exit_code").get<std::int64_t>(),
                     word("verdict"),
                     word("asked_by"),
                     word("software"),
                     facts.at("ledger_head").at("id").get<std::int64_t>(),
                     facts.at("ledger_head").at("hash").get<std::string>(),
                     text,
                     now};
  } catch (const json::exception&) {
    return bad();
  }
}

Expected<std::int64_t> push_nights(const fs::path& reports,
                                   std::chrono::sys_seconds now,
                                   Database& database) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& one : fs::directory_iterator(reports, error)) {
    if (one.path().extension() == ".json") files.push_back(one.path());
  }
  if (error) {
    return failure({Code::FileUnreadable,
                    {reports.string(), 0, 0},
                    "folder not readable: " + error.message(),
                    "the folder of [nightly] reports"});
  }
  std::ranges::sort(files);
  std::int64_t n_nights = 0;
  for (const fs::path& file : files) {
    PANELCAL_TRY(const StoredRow row, night_row(file, iso_8601(now)));
    if (row.empty()) continue;
    const StoredValue key[] = {row[0], row[1], row[12]};
    constexpr std::string_view kSame = "WHERE machine = ? AND started = ? AND ledger_sha256 = ?";
    PANELCAL_TRY(const std::vector<StoredRow> present,
                 database.rows(fmt::format("SELECT document FROM night {}", kSame), key));
    if (!present.empty() && present[0][0] == row[13]) continue;
    PANELCAL_CHECK(database.run(fmt::format("DELETE FROM night {}", kSame), key));
    PANELCAL_CHECK(insert(database,
                          "night",
                          "machine, started, night, finished, may_drill, drill_until, outcome, "
                          "exit_code, verdict, asked_by, software, ledger_entry, ledger_sha256, "
                          "document, pushed",
                          std::span(&row, 1)));
    ++n_nights;
  }
  return n_nights;
}

std::string text_in(const StoredValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text == nullptr ? std::string() : *text;
}

std::int64_t whole_of(const StoredValue& value) {
  const auto* whole = std::get_if<std::int64_t>(&value);
  return whole == nullptr ? 0 : *whole;
}

/// The state by the last night alone.
void judge(FleetMachine& machine,
           bool may_drill,
           const std::string& until,
           const FleetTerms& terms) {
  if (!may_drill) {
    machine.state = FleetState::Hold;
    machine.why = machine.verdict;
    return;
  }
  const auto finished = from_iso_8601(machine.finished);
  if (!finished || (!until.empty() && !from_iso_8601(until))) {
    machine.why = "the time of its last night cannot be read";
    return;
  }
  // A night that could not be pushed, and held, would look like this too.
  const std::chrono::sys_seconds next = *finished + terms.max_age;
  const std::chrono::sys_seconds end = std::min(from_iso_8601(until).value_or(next), next);
  constexpr std::chrono::hours kFastClock{1};
  if (*finished > terms.now + kFastClock) {
    machine.why = "its last night is of the future, " + machine.finished + ": a clock is wrong";
  } else if (terms.now > next) {
    machine.why = "no night since " + machine.finished;
  } else if (terms.now > end) {
    machine.why = "its last night said: drill until " + until;
  } else {
    machine.state = FleetState::Drill;
    machine.until = iso_8601(end);
    machine.why = machine.verdict;
  }
}

/// Entries behind the last night: no night has judged what they changed.
Expected<void> look_behind(FleetMachine& machine,
                           std::int64_t night_entry,
                           const std::string& night_hash,
                           Database& database) {
  const StoredValue head[] = {night_entry, night_hash};
  PANELCAL_TRY(const std::vector<StoredRow> ledger,
               database.rows("SELECT ledger FROM entry WHERE number = ? AND sha256 = ?", head));
  if (ledger.empty()) {
    if (machine.state != FleetState::Drill) return {};
    machine.state = FleetState::Unknown;
    machine.why = "the ledger of its last night was not pushed";
    return {};
  }
  const StoredValue behind[] = {ledger[0][0], machine.machine, night_entry};
  PANELCAL_TRY(
      const std::vector<StoredRow> later,
      database.rows("SELECT number, time, kind, subject, verdict, asked_by FROM entry WHERE "
                    "ledger = ? AND machine = ? AND number > ? ORDER BY number DESC",
                    behind));
  if (later.empty()) return {};
  machine.n_entries_since = static_cast<std::int64_t>(later.size());
  const StoredRow& newest = later.front();
  machine.newest_entry = fmt::format("entry {} of {}: {} {} {} by {}",
                                     whole_of(newest[0]),
                                     text_in(newest[1]),
                                     text_in(newest[2]),
                                     text_in(newest[3]),
                                     text_in(newest[4]),
                                     text_in(newest[5]));
  const bool has_changed = std::ranges::any_of(later, [](const StoredRow& row) {
    return text_in(row[4]) == word(LedgerVerdict::Installed) ||
           text_in(row[4]) == word(LedgerVerdict::RolledBack);
  });
  if (machine.state == FleetState::Drill && has_changed) {
    machine.state = FleetState::Unknown;
    machine.until.clear();
    machine.why = "no night has judged what has changed since: " + machine.newest_entry;
  }
  return {};
}

/// Two machines that have one name: their nights stand in two ledgers, and at the same time. (Of a
/// ledger that was begun anew the nights are behind those of the old one.)
Expected<void> look_beside(std::map<std::string, FleetMachine>& machines, Database& database) {
  PANELCAL_TRY(const std::vector<StoredRow> spans,
               database.rows("SELECT night.machine, min(night.started), max(night.finished) FROM "
                             "night JOIN entry ON entry.number = night.ledger_entry AND "
                             "entry.sha256 = night.ledger_sha256 GROUP BY night.machine, "
                             "entry.ledger ORDER BY 1, 2"));
  for (std::size_t i = 1; i < spans.size(); ++i) {
    const StoredRow& before = spans[i - 1];
    if (before[0] != spans[i][0] || text_in(before[2]) < text_in(spans[i][1])) continue;
    FleetMachine& machine = machines[text_in(before[0])];
    machine.state = FleetState::Unknown;
    machine.until.clear();
    machine.why =
        "two ledgers have nights of this name at the same time: two machines have one name";
  }
  return {};
}

}  // namespace

Expected<PushedLedger> push_ledger(const Ledger& ledger,
                                   const std::string& file,
                                   const fs::path& reports,
                                   std::chrono::sys_seconds now,
                                   Database& database) {
  PANELCAL_TRY(Transaction transaction, Transaction::begin(database));
  PushedLedger pushed;
  PANELCAL_TRY(pushed.n_entries, push_entries(ledger, file, now, database));
  if (!reports.empty()) {
    PANELCAL_TRY(pushed.n_nights, push_nights(reports, now, database));
  }
  PANELCAL_CHECK(transaction.commit());
  return pushed;
}

std::string_view name(FleetState state) {
  switch (state) {
    case FleetState::Drill:
      return "drill";
    case FleetState::Hold:
      return "hold";
    case FleetState::Unknown:
      break;
  }
  return "unknown";
}

Expected<std::vector<FleetMachine>> fleet(Database& database, const FleetTerms& terms) {
  std::map<std::string, FleetMachine> machines;
  PANELCAL_TRY(const std::vector<StoredRow> known,
               database.rows("SELECT entry.machine, max(ledger.pushed) FROM entry JOIN ledger ON "
                             "ledger.id = entry.ledger GROUP BY entry.machine"));
  for (const StoredRow& row : known) {
    FleetMachine& machine = machines[text_in(row[0])];
    machine.machine = text_in(row[0]);
    machine.pushed = text_in(row[1]);
    machine.why = "none of its nights was pushed";
  }
  PANELCAL_TRY(
      const std::vector<StoredRow> nights,
      database.rows("SELECT machine, night, finished, verdict, outcome, asked_by, may_drill, "
                    "drill_until, ledger_entry, ledger_sha256, pushed FROM last_night"));
  for (const StoredRow& row : nights) {
    FleetMachine& machine = machines[text_in(row[0])];
    machine.machine = text_in(row[0]);
    machine.night = text_in(row[1]);
    machine.finished = text_in(row[2]);
    machine.verdict = text_in(row[3]);
    machine.outcome = text_in(row[4]);
    machine.asked_by = text_in(row[5]);
    machine.pushed = std::max(machine.pushed, text_in(row[10]));
    judge(machine, whole_of(row[6]) != 0, text_in(row[7]), terms);
    PANELCAL_CHECK(look_behind(machine, whole_of(row[8]), text_in(row[9]), database));
  }
  PANELCAL_CHECK(look_beside(machines, database));
  std::vector<FleetMachine> out;
  for (auto& [name, machine] : machines) out.push_back(std::move(machine));
  return out;
}

}  // namespace panelcal::gather
