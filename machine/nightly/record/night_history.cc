// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_history.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "calib/base/json/strict_json.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

constexpr std::string_view kVariance = "variance: ";
constexpr std::string_view kDegrees = "degrees of freedom: ";
constexpr std::string_view kLow = "level: ";
constexpr std::string_view kHigh = "level from above: ";
constexpr std::string_view kUsedUp = "used up";
constexpr std::string_view kBegunAnew = "begun anew";

/// Of one calibration within a machine: "spindle-camera spindle 1 station 1".
std::string what(const LedgerKey& key) {
  return fmt::format("{} {}", word(key.kind), key.subject);
}

Expected<std::vector<LedgerEntry>> begun_anew_of_all(const Ledger& ledger) {
  LedgerFilter filter;
  filter.kind = LedgerKind::Night;
  filter.subject = std::string(kBegunAnew);
  return ledger.list(filter);
}

std::string history_json_text(const nlohmann::ordered_json& document) {
  // Text that is no UTF-8 must not throw.
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void put_qualities(const std::vector<NightSpread>& spreads,
                   const std::vector<NightLevel>& levels,
                   std::vector<LedgerParameter>& parameters) {
  for (const NightSpread& spread : spreads) {
    parameters.push_back(
        {std::string(kVariance) + spread.name, spread.variance, spread.unit + "^2"});
    parameters.push_back({std::string(kDegrees) + spread.name, spread.degrees_of_freedom, "1"});
  }
  for (const NightLevel& level : levels) {
    parameters.push_back(
        {std::string(level.low_is_bad ? kLow : kHigh) + level.name, level.value, level.unit});
  }
}

std::optional<double> find_parameter(const LedgerRecord& record, std::string_view name) {
  const auto i = record.find(name);
  if (!i) return std::nullopt;
  return record.parameters[*i].value;
}

}  // namespace

LedgerKey companion_key(const LedgerKey& key) {
  return {key.machine, LedgerKind::SelfTest, what(key)};
}

LedgerKey fresh_start_key(const LedgerKey& key) {
  return {key.machine, LedgerKind::Night, "fresh start: " + what(key)};
}

QualityNight qualities_of(const LedgerEntry& entry) {
  QualityNight night;
  night.time = entry.time;
  for (const LedgerParameter& p : entry.record.parameters) {
    if (p.name.starts_with(kVariance)) {
      const std::string name = p.name.substr(kVariance.size());
      const auto degrees = find_parameter(entry.record, std::string(kDegrees) + name);
      const std::string unit = p.unit.ends_with("^2") ? p.unit.substr(0, p.unit.size() - 2) : "";
      if (degrees) night.spreads.push_back({name, unit, p.value, *degrees});
    } else if (p.name.starts_with(kLow)) {
      night.levels.push_back({p.name.substr(kLow.size()), p.unit, p.value, true});
    } else if (p.name.starts_with(kHigh)) {
      night.levels.push_back({p.name.substr(kHigh.size()), p.unit, p.value, false});
    }
  }
  return night;
}

namespace {

/// Content of a companion's result; empty for a result of another program.
struct StepWords {
  std::string night;
  NightState state = NightState::Held;
  std::string summary;
};

std::optional<StepWords> step_words(const std::string& result) {
  const Expected<nlohmann::json> document = internal::parse_strict_json(result, "night-step");
  if (!document || !document->is_object()) return std::nullopt;
  const auto text = [&](const char* key) {
    const auto found = document->find(key);
    return found != document->end() && found->is_string() ? found->get<std::string>()
                                                          : std::string();
  };
  const std::optional<NightState> state = night_state(text("state"));
  if (text("kind") != "night-step" || !state) return std::nullopt;
  return StepWords{text("night"), *state, text("summary")};
}

/// Moves times back that are not before a fresh start: until then the clock may have been wrong,
/// and a person has looked since.
template <class T>
void move_before(std::chrono::sys_seconds fresh_start,
                 std::vector<T>& all,
                 std::optional<std::chrono::sys_seconds>& last) {
  std::chrono::sys_seconds latest = fresh_start;
  for (auto one = all.rbegin(); one != all.rend(); ++one) {
    latest -= std::chrono::seconds(1);
    if (one->time <= latest) break;
    one->time = latest;
  }
  if (!all.empty()) last = all.back().time;
}

std::chrono::sys_seconds after(std::chrono::sys_seconds time,
                               const std::optional<std::chrono::sys_seconds>& before) {
  return before ? std::max(time, *before + std::chrono::seconds(1)) : time;
}

/// Walks through the entries of one calibration in their order.
class Reader {
 public:
  Reader(const Calibration& calibration,
         const std::vector<LedgerEntry>& companions,
         const std::vector<LedgerEntry>& fresh_starts,
         std::chrono::sys_seconds a_week_ago)
      : calibration_(calibration), fresh_starts_(fresh_starts), a_week_ago_(a_week_ago) {
    for (const LedgerEntry& entry : companions) companions_[entry.id] = &entry;
    history_.series = {calibration.axes(), calibration.unit(), {}};
  }

  void add(const LedgerEntry& entry) {
    while (i_fresh_ < fresh_starts_.size() && fresh_starts_[i_fresh_].id < entry.id) {
      start_anew(fresh_starts_[i_fresh_++]);
    }
    const LedgerVerdict verdict = entry.record.verdict;
    const std::optional<LedgerValues> value = calibration_.value_of(entry);
    if (verdict == LedgerVerdict::Installed) {
      in_force_ = entry.id;
      if (value) values_[entry.id] = *value;
    }
    if (verdict == LedgerVerdict::RolledBack && entry.restores) roll_back(*entry.restores);
    note_week_ago(entry);
    if (verdict != LedgerVerdict::Installed && verdict != LedgerVerdict::Refused) return;
    const auto companion = companions_.find(entry.id + 1);
    if (companion != companions_.end()) add_qualities(*companion->second, verdict);
    if (value) add_point(entry, *value, companion != companions_.end());
  }

  NightHistory finish(std::chrono::sys_seconds now) {
    while (i_fresh_ < fresh_starts_.size()) start_anew(fresh_starts_[i_fresh_++]);
    for (const auto& last : {last_, last_quality_}) {
      if (last && *last - now > std::max(kMostAhead, history_.ahead.value_or(kMostAhead))) {
        history_.ahead = *last - now;
        history_.ahead_id = latest_id_;
      }
    }
    history_.is_fresh_start = is_fresh_;
    history_.is_fresh_for_quality = is_fresh_quality_;
    return std::move(history_);
  }

 private:
  void start_anew(const LedgerEntry& fresh_start) {
    is_fresh_ = is_fresh_quality_ = true;
    latest_id_ = fresh_start.id;
    latest_ = fresh_start.time;
    move_before(fresh_start.time, history_.series.points, last_);
    move_before(fresh_start.time, history_.qualities, last_quality_);
  }

  /// Later ones may have a time of their own that is right.
  void note_latest(std::int64_t id, std::chrono::sys_seconds time) {
    if (latest_id_ > 0 && time <= latest_) return;
    latest_id_ = id;
    latest_ = time;
  }

  /// A calibration that was installed after the restored one was no good.
  void roll_back(std::int64_t restored) {
    in_force_ = restored;
    for (std::size_t i = 0; i < history_.ids.size(); ++i) {
      DriftPoint& point = history_.series.points[i];
      point.is_left_out =
          history_.ids[i] != restored && (point.is_left_out || history_.ids[i] > restored);
    }
    for (std::size_t i = 0; i < quality_ids_.size(); ++i) {
      QualityNight& night = history_.qualities[i];
      night.is_left_out =
          quality_ids_[i] != restored && (night.is_left_out || quality_ids_[i] > restored);
    }
  }

  void note_week_ago(const LedgerEntry& entry) {
    if (entry.time > a_week_ago_ || !in_force_) return;
    const auto value = values_.find(*in_force_);
    if (value != values_.end()) history_.week_ago = value->second;
  }

  void add_qualities(const LedgerEntry& companion, LedgerVerdict verdict) {
    QualityNight night = qualities_of(companion);
    const auto used_up = find_parameter(companion.record, kUsedUp);
    if (used_up) history_.used_up = static_cast<int>(*used_up);
    if (night.spreads.empty() && night.levels.empty()) return;
    note_latest(companion.id - 1, companion.time);
    night.time = after(night.time, last_quality_);
    last_quality_ = night.time;
    night.is_left_out = verdict != LedgerVerdict::Installed;
    night.is_fresh_start = is_fresh_quality_;
    if (!night.is_left_out) is_fresh_quality_ = false;
    history_.qualities.push_back(std::move(night));
    quality_ids_.push_back(companion.id - 1);
  }

  void add_point(const LedgerEntry& entry, const LedgerValues& value, bool is_of_a_night) {
    note_latest(entry.id, entry.time);
    DriftPoint point;
    point.time = after(entry.time, last_);
    last_ = point.time;
    point.value = value.value;
    point.cov = value.cov;
    point.temperature_c = entry.record.temperature_degC;
    point.is_left_out = entry.record.verdict == LedgerVerdict::Refused;
    // A person who installs by hand after a night has refused has looked and accepted it.
    if (!point.is_left_out && !is_of_a_night && was_refused_) is_fresh_ = true;
    was_refused_ = point.is_left_out;
    point.is_fresh_start = is_fresh_;
    if (!point.is_left_out) is_fresh_ = false;
    history_.series.points.push_back(std::move(point));
    history_.ids.push_back(entry.id);
    history_.is_by_hand.push_back(!is_of_a_night);
    history_.asked_by.push_back(entry.record.asked_by);
    const auto in_force = in_force_ ? values_.find(*in_force_) : values_.end();
    history_.in_force_values.emplace_back();
    if (in_force != values_.end()) history_.in_force_values.back() = in_force->second.value;
  }

  const Calibration& calibration_;
  const std::vector<LedgerEntry>& fresh_starts_;
  std::chrono::sys_seconds a_week_ago_;
  std::map<std::int64_t, const LedgerEntry*> companions_;
  std::map<std::int64_t, LedgerValues> values_;
  std::vector<std::int64_t> quality_ids_;  ///< of the entries that history_.qualities go with
  std::size_t i_fresh_ = 0;
  bool is_fresh_ = false;
  bool is_fresh_quality_ = false;
  bool was_refused_ = false;
  std::optional<std::chrono::sys_seconds> last_;
  std::optional<std::chrono::sys_seconds> last_quality_;
  std::optional<std::int64_t> in_force_;
  std::int64_t latest_id_ = 0;  ///< since the newest fresh start; with it, if nothing came later
  std::chrono::sys_seconds latest_{};
  NightHistory history_;
};

std::int64_t last_id(const std::vector<LedgerEntry>& entries) {
  return entries.empty() ? 0 : entries.back().id;
}

/// The newest entry of this night, unless a person has since said that it starts anew.
Expected<std::optional<NightHistory::Tonight>> find_tonight(
    const Ledger& ledger,
    const std::vector<LedgerEntry>& entries,
    const std::vector<LedgerEntry>& companions,
    std::int64_t last_fresh_start,
    const std::string& night) {
  std::optional<NightHistory::Tonight> none;
  if (companions.empty() || companions.back().id < last_fresh_start) return none;
  PANELCAL_TRY(const std::string result, ledger.result(companions.back().id));
  const std::optional<StepWords> words = step_words(result);
  if (!words || words->night != night) return none;
  const auto entry = std::ranges::find(entries, companions.back().id - 1, &LedgerEntry::id);
  if (entry == entries.end()) return none;
  return NightHistory::Tonight{*entry, words->state, words->summary};
}

}  // namespace

Expected<NightHistory> read_night_history(const Ledger& ledger,
                                          const Calibration& calibration,
                                          const std::string& night,
                                          std::chrono::sys_seconds now) {
  const LedgerKey key = calibration.key();
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, ledger.list(key, kMostNights));
  PANELCAL_TRY(const std::vector<LedgerEntry> companions,
               ledger.list(companion_key(key), kMostNights));
  PANELCAL_TRY(const std::vector<LedgerEntry> fresh_starts,
               ledger.list(fresh_start_key(key), kMostNights));
  PANELCAL_TRY(const std::vector<LedgerEntry> begun,
               ledger.list({key.machine, LedgerKind::Night, std::string(kBegunAnew)}, kMostNights));
  Reader reader(calibration, companions, fresh_starts, now - std::chrono::days(7));
  for (const LedgerEntry& entry : entries) reader.add(entry);
  NightHistory history = reader.finish(now);
  PANELCAL_TRY(history.in_force, ledger.in_force(key));
  if (history.in_force) history.in_force_value = calibration.value_of(*history.in_force);
  history.is_unconfirmed = last_id(begun) > last_id(fresh_starts);
  PANELCAL_TRY(history.tonight,
               find_tonight(ledger, entries, companions, last_id(fresh_starts), night));
  return history;
}

void accept_moves_by_hand(NightHistory& history, double limit) {
  std::vector<DriftPoint>& points = history.series.points;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto& before = history.in_force_values[i - 1];
    if (!history.is_by_hand[i] || points[i].is_left_out || !before) continue;
    if (!((points[i].value - *before).norm() <= limit)) points[i].is_fresh_start = true;
  }
}

LedgerDraft companion_draft(const LedgerRecord& calibration,
                            const std::string& night,
                            const CalibrationResult* measurement,
                            int used_up,
                            NightState state,
                            const std::string& summary) {
  LedgerDraft draft;
  draft.record = calibration;
  draft.record.key = companion_key(calibration.key);
  draft.record.verdict = LedgerVerdict::Measured;
  draft.record.reason.clear();
  draft.record.inputs.clear();
  draft.record.covariance.reset();
  draft.record.replaces.reset();
  draft.record.parameters = {{std::string(kUsedUp), static_cast<double>(used_up), "1"}};
  if (measurement != nullptr) {
    put_qualities(measurement->spreads, measurement->levels, draft.record.parameters);
  }
  draft.result = history_json_text({{"kind", "night-step"},
                                    {"version", 1},
                                    {"night", night},
                                    {"state", name(state)},
                                    {"summary", summary}});
  return draft;
}

LedgerDraft self_test_draft(const std::string& machine,
                            const QualityNight& quality,
                            const RecordWords& words,
                            const std::string& problem) {
  LedgerDraft draft;
  LedgerRecord& record = draft.record;
  record.key = self_test_key(machine);
  record.verdict = problem.empty() ? LedgerVerdict::Measured : LedgerVerdict::Refused;
  record.reason = problem;
  record.asked_by = words.asked_by;
  record.software = words.software;
  record.temperature_degC = words.temperature_degC;
  put_qualities(quality.spreads, quality.levels, record.parameters);
  draft.result = history_json_text({{"kind", "self-test"}, {"version", 1}, {"problem", problem}});
  return draft;
}

LedgerKey self_test_key(const std::string& machine) {
  return {machine, LedgerKind::SelfTest, "before the night"};
}

Expected<SelfTestHistory> read_self_tests(const Ledger& ledger,
                                          const std::string& machine,
                                          std::chrono::sys_seconds now) {
  const LedgerKey key = self_test_key(machine);
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, ledger.list(key, kMostNights));
  PANELCAL_TRY(const std::vector<LedgerEntry> fresh_starts,
               ledger.list(fresh_start_key(key), kMostNights));
  SelfTestHistory history;
  std::optional<std::chrono::sys_seconds> last;
  std::size_t i_fresh = 0;
  for (const LedgerEntry& entry : entries) {
    for (; i_fresh < fresh_starts.size() && fresh_starts[i_fresh].id < entry.id; ++i_fresh) {
      history.is_fresh_start = true;
      move_before(fresh_starts[i_fresh].time, history.nights, last);
    }
    QualityNight night = qualities_of(entry);
    night.time = after(night.time, last);
    last = night.time;
    night.is_left_out = entry.record.verdict == LedgerVerdict::Refused;
    night.is_fresh_start = history.is_fresh_start;
    if (!night.is_left_out) history.is_fresh_start = false;
    history.nights.push_back(std::move(night));
  }
  if (i_fresh < fresh_starts.size()) {
    history.is_fresh_start = true;
    move_before(fresh_starts.back().time, history.nights, last);
  }
  // Their step says that the clock is wrong; how well the mark is seen does not depend on it.
  move_before(now, history.nights, last);
  return history;
}

Expected<LedgerEntry> mark_fresh_start(Ledger& ledger,
                                       const LedgerKey& key,
                                       const FreshStart& words) {
  LedgerDraft draft;
  draft.record.key = fresh_start_key(key);
  draft.record.reason = words.reason;
  draft.record.asked_by = words.asked_by;
  draft.record.software = words.software;
  draft.result = history_json_text({{"kind", "fresh-start"},
                                    {"version", 1},
                                    {"of", {{"kind", word(key.kind)}, {"subject", key.subject}}}});
  return ledger.append(draft);
}

LedgerDraft begun_anew_draft(const std::string& machine,
                             const std::filesystem::path& kept,
                             const RecordWords& words,
                             const std::vector<std::string>& given_up) {
  LedgerDraft draft;
  draft.record.key = {machine, LedgerKind::Night, std::string(kBegunAnew)};
  draft.record.reason = "the ledger before this one is damaged";
  draft.record.asked_by = words.asked_by;
  draft.record.software = words.software;
  draft.result = history_json_text({{"kind", "begun-anew"},
                                    {"version", 1},
                                    {"kept_aside", kept.string()},
                                    {"given_up", given_up}});
  return draft;
}

Expected<bool> was_begun_anew(const Ledger& ledger) {
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, begun_anew_of_all(ledger));
  return !entries.empty();
}

Expected<std::set<std::string>> given_up_hashes(const Ledger& ledger) {
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, begun_anew_of_all(ledger));
  std::set<std::string> hashes;
  for (const LedgerEntry& entry : entries) {
    PANELCAL_TRY(const std::string result, ledger.result(entry.id));
    const Expected<nlohmann::json> document = internal::parse_strict_json(result, "");
    if (!document || !document->is_object() || !document->contains("given_up")) continue;
    for (const nlohmann::json& hash : (*document)["given_up"]) {
      if (hash.is_string()) hashes.insert(hash.get<std::string>());
    }
  }
  return hashes;
}

}  // namespace panelcal
