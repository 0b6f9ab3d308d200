// SPDX-License-Identifier: Apache-2.0
#include "tests/program/prefix_trial.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "tests/fuzz/sieb_meyer_entry.h"
#include "tests/fuzz/walk_checks.h"

namespace panelcal::test {
namespace {

/// A place where a tool works, as the machine is told.
struct WorkedPlace {
  int line = 0;
  int tool = 0;
  Eigen::Vector2d commanded_mm = Eigen::Vector2d::Zero();

  friend bool operator==(const WorkedPlace& a, const WorkedPlace& b) {
    return a.line == b.line && a.tool == b.tool && a.commanded_mm == b.commanded_mm;
  }
};

class WorkedPlaces final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    if (const auto* drill = std::get_if<Drill>(&operation.what)) {
      places_.push_back({operation.line, drill->tool, drill->commanded.in_mm()});
    }
    if (const auto* rout = std::get_if<Rout>(&operation.what)) {
      places_.push_back({operation.line, rout->tool, rout->commanded.in_mm()});
    }
  }
  std::vector<WorkedPlace> take() { return std::move(places_); }

 private:
  std::vector<WorkedPlace> places_;
};

/// Places that are drilled and routed on a bent panel; absent if the program is refused.
std::optional<std::vector<WorkedPlace>> places_of(const WholeFile& file,
                                                  std::string bytes,
                                                  bool accepts_unterminated) {
  DiagnosticLog log;
  Program program = load_program(
      {file.source.file, std::move(bytes)}, log, {.accepts_unterminated = accepts_unterminated});
  program.patterns = file.patterns;
  WalkOptions options;
  options.max_operations = 20'000;
  options.max_measurements = 1'000;
  fuzz::BentSource targets;
  fuzz::BentProbes probes;
  const Survey found = survey(program, options, targets, probes, log);
  if (log.has_errors()) return std::nullopt;
  WorkedPlaces places;
  execute(program, options, found, places, log);
  if (log.has_errors()) return std::nullopt;
  return places.take();
}

std::set<std::size_t> lengths_to_try(std::string_view bytes, std::size_t most) {
  constexpr std::size_t kLast = 40;
  std::set<std::size_t> lengths;
  const std::size_t size = bytes.size();
  const std::size_t step = std::max<std::size_t>(1, (size + most - 1) / most);
  for (std::size_t n = 0; n < size; n += step) {
    lengths.insert(n);
    if (step == 1) continue;
    const std::size_t line_end = std::min(bytes.find('\n', n), size - 1);
    lengths.insert({line_end, std::min(line_end + 1, size - 1)});
  }
  for (std::size_t n = size - std::min(kLast, size); n < size; ++n) lengths.insert(n);
  return lengths;
}

bool begin_alike(const std::vector<WorkedPlace>& some, const std::vector<WorkedPlace>& all) {
  return some.size() <= all.size() && std::equal(some.begin(), some.end(), all.begin());
}

}  // namespace

void try_prefixes(const WholeFile& file, std::size_t most_prefixes, PrefixTrial& trial) {
  const std::string_view bytes = file.source.bytes;
  const auto complain = [&](std::size_t length, std::string_view what) {
    trial.complaints.push_back(
        fmt::format("{}: cut off behind {}: {}",
                    file.source.file,
                    quoted(bytes.substr(length - std::min<std::size_t>(length, 30), 30)),
                    what));
  };
  const auto whole = places_of(file, file.source.bytes, true);
  ++trial.n_files;
  if (whole) ++trial.n_whole;
  for (const std::size_t length : lengths_to_try(bytes, most_prefixes)) {
    ++trial.n_prefixes;
    const std::string prefix(bytes.substr(0, length));
    if (const auto strict = places_of(file, prefix, false)) {
      ++trial.n_as_whole;
      if (strict != whole) complain(length, "accepted as a whole program with other holes");
      continue;
    }
    const auto accepted = places_of(file, prefix, true);
    if (!accepted) continue;
    ++trial.n_accepted;
    if (prefix.find("%%") != prefix.npos) complain(length, "the option accepts SIEB & MEYER");
    if (whole && !begin_alike(*accepted, *whole)) complain(length, "accepted with other holes");
  }
}

}  // namespace panelcal::test
