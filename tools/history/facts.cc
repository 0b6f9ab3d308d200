// SPDX-License-Identifier: Apache-2.0
#include "tools/history/facts.h"

#include <cmath>

namespace panelcal::history {
namespace {

using facts::Json;
using facts::number;

/// To a picometre: smaller parts are rounding, and differ from processor to processor.
double rounded_mm(double value_mm) {
  return std::round(value_mm * 1e9) / 1e9 + 0.0;
}

Json rounded_point(const Eigen::Vector2d& v_mm) {
  return facts::point({rounded_mm(v_mm.x()), rounded_mm(v_mm.y())});
}

Json place_facts(const MovedPlace& moved) {
  Json out = {{"nominal_mm", rounded_point(moved.place.nominal.in_mm())},
              {"shift_mm", rounded_point(moved.shift.in_mm())},
              {"line", moved.place.line}};
  if (!moved.place.file.empty()) out["file"] = moved.place.file;
  out["tool"] = moved.place.tool;
  out["path"] = moved.place.path;
  return out;
}

Json points(std::span<const Position<frame::Nominal>> places) {
  Json out = Json::array();
  for (const Position<frame::Nominal>& place : places) out.push_back(rounded_point(place.in_mm()));
  return out;
}

}  // namespace

Json entry_facts(const LedgerEntry& entry, bool in_force) {
  // As its hash covers it, so that no fact is left out.
  Json out = Json::parse(ledger_entry_json(entry));
  out.erase("panelcal");
  out["hash"] = entry.hash;
  out["in_force"] = in_force;
  return out;
}

Json changes_facts(std::span<const ParameterChange> changes) {
  Json out = Json::array();
  for (const ParameterChange& c : changes) {
    out.push_back({{"name", c.name},
                   {"unit", c.unit},
                   {"before", number(c.before)},
                   {"after", number(c.after)},
                   {"change", number(c.change())},
                   {"change_sigma", number(c.sigma)}});
  }
  return out;
}

Json job_shift_facts(const JobShift& shift, const JobShiftWords& words) {
  const HoleShiftSummary& s = shift.summary;
  Json sample = Json::array();
  for (const MovedPlace& moved : shift.sample) sample.push_back(place_facts(moved));
  return {{"program", words.program_file},
          {"places", s.n_holes},
          {"holes", shift.n_drilled},
          {"targets", shift.targets.size()},
          {"uncorrected", shift.n_still},
          {"rout_moves_left_out", !shift.has_routs},
          {"max_mm", rounded_mm(s.max.in_mm())},
          {"p95_mm", rounded_mm(s.p95.in_mm())},
          {"p95_relative_error", s.p95_relative_error},
          {"rms_mm", rounded_mm(s.rms.in_mm())},
          {"mean_mm", rounded_mm(s.mean.in_mm())},
          {"mean_shift_mm", rounded_point(s.mean_shift.in_mm())},
          {"uniform", shift.is_uniform()},
          {"worst", place_facts(shift.worst)},
          {"sample", std::move(sample)},
          {"outline_mm", points(shift.hull)},
          {"targets_mm", points(shift.targets)},
          {"notes", words.notes}};
}

Json verify_facts(const LedgerHead& head, const NotingFiles& held) {
  Json files = Json::array();
  for (const NotedFile& file : held.noted) {
    files.push_back({{"file", file.file.string()}, {"entry", file.head.id}});
  }
  return {{"entries", head.id},
          {"head", head.hash},
          {"held_against", std::move(files)},
          {"without_head", held.n_without}};
}

}  // namespace panelcal::history
