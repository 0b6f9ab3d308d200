// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/job_facts.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <vector>

#include "machine/job/facts/sections.h"
#include "machine/job/result.h"

namespace panelcal {
namespace facts {
namespace {

constexpr int kJobFactsVersion = 1;
/// More places than this are packed.
constexpr std::size_t kMaxPlainPlaces = 10'000;

std::string_view verdict_word(Verdict verdict) {
  switch (verdict) {
    case Verdict::Drill:
      return "drill";
    case Verdict::Warned:
      return "warned";
    case Verdict::Hold:
      return "hold";
    case Verdict::Forced:
      break;
  }
  return "forced";
}

/// Few places as numbers that people can read, many as bytes.
template <class T>
Json column(const std::vector<T>& values, bool is_packed) {
  if (!is_packed) {
    Json out = Json::array();
    for (const T value : values) {
      if constexpr (std::is_floating_point_v<T>) {
        // Six digits behind the point tell a nanometre; the rest is the column's own rounding.
        out.push_back(number(std::round(static_cast<double>(value) * 1e6) / 1e6));
      } else {
        out.push_back(value);
      }
    }
    return out;
  }
  if constexpr (std::is_same_v<T, float> || std::is_same_v<T, std::uint32_t>) {
    return packed(values);
  } else if constexpr (std::is_same_v<T, double>) {
    return packed(std::vector<float>(values.begin(), values.end()));
  } else {
    return packed(std::vector<std::uint32_t>(values.begin(), values.end()));
  }
}

/// Small risks must not be rounded away.
Json risk_column(const std::vector<float>& risks, bool is_packed) {
  if (is_packed) return packed(risks);
  Json out = Json::array();
  for (const float risk : risks) out.push_back(number(static_cast<double>(risk)));
  return out;
}

Json table_json(const PlaceTable& places) {
  const bool is_packed = places.size() > kMaxPlainPlaces;
  Json boards = Json::array();
  for (const InstancePath& path : places.boards) boards.push_back(board_json(path));
  return {{"n", places.size()},
          {"is_packed", is_packed},
          {"boards", boards},
          {"files", places.files},
          {"kind", column(places.kind, is_packed)},
          {"nominal_x_mm", column(places.nominal_x_mm, is_packed)},
          {"nominal_y_mm", column(places.nominal_y_mm, is_packed)},
          {"shift_x_um", column(places.shift_x_um, is_packed)},
          {"shift_y_um", column(places.shift_y_um, is_packed)},
          {"sigma_um", column(places.sigma_um, is_packed)},
          {"risk", risk_column(places.risk, is_packed)},
          {"line", column(places.line, is_packed)},
          {"tool", column(places.tool, is_packed)},
          {"board", column(places.board, is_packed)},
          {"file", column(places.file, is_packed)}};
}

/// As the night's record has it, which `history verify --against` reads too; null without a ledger.
Json ledger_head_json(const JobFactsInput& input) {
  for (const auto& [key, value] : input.provenance) {
    if (key != "ledger head") continue;
    std::int64_t id = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), id);
    if (error != std::errc() || end == value.data() + value.size()) return {};
    return {{"id", id}, {"hash", std::string(end + 1, value.data() + value.size())}};
  }
  return {};
}

Json provenance_json(const JobFactsInput& input) {
  Json rows = Json::array();
  for (const auto& [key, value] : input.provenance) {
    rows.push_back({{"key", key}, {"value", value}});
  }
  return rows;
}

}  // namespace

Json board_json(std::span<const int> path) {
  Json out = Json::array();
  for (const int index : path) out.push_back(index);
  return out;
}

Json tools_json(const Tally& tally) {
  Json tools = Json::array();
  const auto count = [](const Tally::CountByTool& counts, int tool) {
    const auto at = counts.find(tool);
    return at == counts.end() ? 0 : at->second;
  };
  for (const int tool : tally.tools_used()) {
    const auto known = tally.tools().find(tool);
    const bool has_diameter = known != tally.tools().end() && known->second.diameter;
    tools.push_back({{"number", tool},
                     {"diameter_mm", has_diameter ? Json(known->second.diameter->in_mm()) : Json()},
                     {"n_holes", count(tally.holes_by_tool(), tool)},
                     {"n_slots", count(tally.slots_by_tool(), tool)},
                     {"n_routs", count(tally.routs_by_tool(), tool)}});
  }
  return tools;
}

Json places_json(const JobFactsInput& input) {
  if (input.tally == nullptr) return {};
  const Tally& tally = *input.tally;
  return {{"n_holes", tally.n_holes()},
          {"n_slots", tally.n_slots()},
          {"n_routs", tally.n_routs()},
          {"routed_length_mm", number(tally.routed_length().in_mm())},
          {"max_shift_um", number(tally.max_shift().in_um())},
          {"max_sigma_um", number(tally.max_sigma().in_um())},
          {"sigma_leaves_out", input.unstated},
          {"tools", tools_json(tally)},
          {"table", input.places == nullptr ? Json() : table_json(*input.places)}};
}

Json messages_json(std::span<const Diagnostic> diagnostics) {
  Json rows = Json::array();
  for (const Severity severity : {Severity::Error, Severity::Warning}) {
    for (const Diagnostic& diagnostic : diagnostics) {
      if (diagnostic.severity() != severity) continue;
      rows.push_back({{"severity", severity == Severity::Error ? "error" : "warning"},
                      {"code", info(diagnostic.code).slug},
                      {"text", diagnostic.text()},
                      {"advice", info(diagnostic.code).advice}});
    }
  }
  return rows;
}

}  // namespace facts

JobFactsInput facts_input(const JobResult& result) {
  JobFactsInput input;
  input.source = result.source;
  input.survey = result.survey.get();
  input.tally = result.is_executed ? &result.tally : nullptr;
  input.places = result.is_executed ? result.places.get() : nullptr;
  input.truth = result.is_executed ? result.truth.get() : nullptr;
  input.verdict = result.verdict.get();
  input.depth = result.depth.get();
  input.unstated = result.unstated;
  input.worst_hole = result.worst_hole;
  input.worst_number = result.worst_number;
  if (result.surface_use) input.surface_use = result.surface_use->summary();
  return input;
}

std::string job_facts(const JobFactsInput& input) {
  const Survey& survey = facts::survey_of(input);
  const std::vector<facts::TargetFact> targets = facts::target_facts(survey);
  facts::Json document = facts::envelope("job", facts::kJobFactsVersion);
  document["program"] = input.program_file;
  document["machine"] = input.machine_name;
  document["source"] = input.source;
  document["output"] = input.output_file.empty() ? facts::Json() : facts::Json(input.output_file);
  document["verdict"] = {{"word", facts::verdict_word(facts::verdict_of(input))},
                         {"grounds", facts::verdict_sentence(input)},
                         {"next", facts::next_step(input)}};
  document["n_found"] = facts::n_found(survey);
  document["n_left_out"] = facts::n_dropped(survey);
  document["targets"] = facts::targets_json(input, targets);
  document["series"] = facts::series_json(survey);
  document["all_series"] = facts::pooled_chi_square_json(survey);
  document["places"] = facts::places_json(input);
  document["tolerance"] = facts::tolerance_json(input);
  document["depth"] = facts::depth_json(input.depth);
  document["budget"] = facts::budget_json(input.worst_hole);
  document["calibrations"] = facts::calibrations_json(survey);
  document["focus"] = facts::focus_json(survey);
  document["surface"] = facts::surface_json(survey, input.surface_use);
  document["messages"] = facts::messages_json(input.diagnostics);
  document["truth"] = facts::truth_json(input.truth);
  document["ledger_head"] = facts::ledger_head_json(input);
  document["provenance"] = facts::provenance_json(input);
  return facts::text(document);
}

}  // namespace panelcal
