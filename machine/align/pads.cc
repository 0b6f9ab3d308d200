// SPDX-License-Identifier: Apache-2.0
#include "machine/align/pads.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "calib/advice/added_targets.h"
#include "calib/advice/convex_hull.h"
#include "calib/base/amount.h"
#include "calib/base/files/atomic_file.h"
#include "machine/align/pad_readers.h"
#include "machine/job/alignment_check.h"
#include "machine/job/checked_program.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::FoundPad;
using internal::FoundPads;

/// Larger files are no board's.
constexpr std::size_t kMostBytes = std::size_t{1} << 28;
/// Pads that are nearer to each other than this are one.
constexpr double kSamePad_mm = 1e-3;
/// A vision tool is of a pad's size if the two differ by no more.
constexpr double kSameSize = 0.1;

Diagnostic usage_of(const std::string& file, int line, std::string what, std::string expected) {
  return {Code::Usage, {file, line, 0}, std::move(what), std::move(expected)};
}

Expected<FoundPads> panel_targets(const Survey& nominal,
                                  const Program& program,
                                  const MachineConfig& machine) {
  const std::string& file = program.source.file;
  const SeriesResult* base = nullptr;
  for (const SeriesResult& series : nominal.series) {
    if (series.level != CorrectionLevel::Base) continue;
    if (base != nullptr) {
      return failure(usage_of(
          file,
          series.line,
          fmt::format("a second series of panel targets, after that of line {}", base->line),
          "a program with one, or the pads as a list \"X,Y;X,Y\""));
    }
    base = &series;
  }
  FoundPads found{{}, "targets"};
  for (const std::size_t i : base->measurements) {
    const MeasurementRequest& request = nominal.measurements[i].request;
    const Displacement<frame::Machine> moved = request.work_zero - configured_zero(machine.walk);
    const bool is_moved = moved.in_mm().norm() > kSamePad_mm;
    if (request.axes != ObservedAxes::Both || is_moved) {
      return failure(usage_of(file,
                              request.line,
                              is_moved
                                  ? "the target counts from another work zero than machine.toml's"
                                  : "the target is a slot, of which one coordinate counts",
                              "the pads as a list \"X,Y;X,Y\""));
    }
    found.pads.push_back({{.nominal = request.nominal,
                           .line = request.line,
                           .command = request.command,
                           .settings = request.settings},
                          std::nullopt});
  }
  return found;
}

/// Every hole. Its diameter says nothing of the pad around it.
class HoleList final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    places.push_back(drill->nominal);
    pads.push_back({{.nominal = drill->nominal, .line = operation.line}, std::nullopt});
  }

  std::vector<Position<frame::Nominal>> places;
  std::vector<FoundPad> pads;
};

/// Those of all holes between which the worst hole is known best (docs/howto/plan.md).
Expected<FoundPads> best_holes(const Program& program,
                               const WalkOptions& options,
                               const Survey& nominal,
                               std::size_t n) {
  HoleList holes;
  DiagnosticLog ignored;
  execute(program, options, nominal, holes, ignored);
  const std::vector<Position<frame::Nominal>> corners = convex_hull(holes.places);
  // Leverage is convex: no place inside of the hull tells more than its corners.
  const Addition best =
      best_additions({.model = options.model.value_or(default_model(static_cast<int>(n))),
                      .targets = {},
                      .candidates = corners,
                      .corners = corners},
                     n);
  if (!best.worst_after) {
    return failure(usage_of(
        program.source.file,
        0,
        fmt::format(
            "{} of its {} do not determine the model", n, amount(holes.places.size(), "hole")),
        "pads that do not lie in one line, as a list \"X,Y;X,Y\""));
  }
  FoundPads found{{}, "holes, the best by leverage"};
  for (const std::size_t i : best.chosen) {
    const auto at = std::ranges::find_if(
        holes.places, [&](const auto& place) { return (place - corners[i]).in_mm().norm() == 0; });
    found.pads.push_back(holes.pads[static_cast<std::size_t>(at - holes.places.begin())]);
  }
  return found;
}

Expected<FoundPads> pads_of_program(const std::string& path,
                                    const PadChoice& choice,
                                    const MachineConfig& machine) {
  ReadOptions reading = machine.reading;
  reading.take(choice.reading);
  DiagnosticLog log;
  const std::optional<Program> program = read_program(path, std::move(reading), log);
  if (program && choice.read) PANELCAL_CHECK(choice.read(*program));
  const Survey nominal = program ? survey_nominal(*program, machine.walk, log) : Survey();
  const auto first_error = std::ranges::find(log.kept(), Severity::Error, &Diagnostic::severity);
  if (first_error != log.kept().end()) return failure(*first_error);
  if (choice.n_best_holes) {
    return best_holes(
        *program, machine.walk, nominal, static_cast<std::size_t>(*choice.n_best_holes));
  }
  const bool has_targets = std::ranges::any_of(nominal.series, [](const SeriesResult& series) {
    return series.level == CorrectionLevel::Base;
  });
  if (has_targets) return panel_targets(nominal, *program, machine);
  return failure(usage_of(path,
                          0,
                          "the program measures no target of the panel",
                          "--auto 4 to look at its own holes, or the pads as a list \"X,Y;X,Y\""));
}

Expected<FoundPads> find_pads(const std::string& pads,
                              const PadChoice& choice,
                              const MachineConfig& machine) {
  if (internal::is_pad_list(pads)) return internal::pads_of_list(pads);
  PANELCAL_TRY(const std::string bytes, read_file(pads, kMostBytes));
  if (internal::is_gerber(bytes)) return internal::pads_of_gerber(bytes, pads, choice.diameter);
  if (internal::is_placement(bytes)) return internal::pads_of_placement(bytes, pads);
  return pads_of_program(pads, choice, machine);
}

/// The vision tool that looks for pads of a size: the only one, or the only one of that size.
std::optional<int> tool_for(const std::optional<Length>& diameter, const MachineConfig& machine) {
  if (machine.vision_tools.size() == 1) return machine.vision_tools.begin()->first;
  std::optional<int> found;
  for (const auto& [number, target] : machine.vision_tools) {
    if (!diameter || !target.size) continue;
    if (std::abs(*target.size / *diameter - 1) > kSameSize) continue;
    if (found) return std::nullopt;
    found = number;
  }
  return found;
}

Expected<void> check_places(const PadList& list) {
  const std::vector<Pad>& pads = list.pads;
  if (pads.empty() || pads.size() > kMostPads) {
    return failure(usage_of(list.file,
                            0,
                            amount(pads.size(), "pad") + " to look at",
                            fmt::format("1 to {}", kMostPads)));
  }
  for (std::size_t i = 1; i < pads.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if ((pads[i].nominal - pads[k].nominal).in_mm().norm() > kSamePad_mm) continue;
      return failure(usage_of(list.file,
                              pads[i].line,
                              fmt::format("pad {} lies where pad {} lies", i + 1, k + 1),
                              "each pad once"));
    }
  }
  return {};
}

}  // namespace

Expected<PadList> read_pads(const std::string& pads,
                            const PadChoice& choice,
                            const MachineConfig& machine) {
  PANELCAL_TRY(FoundPads found, find_pads(pads, choice, machine));
  const bool is_list = internal::is_pad_list(pads);
  PadList list{is_list ? "PADS" : pads, {}, {}};
  list.words = amount(found.pads.size(), "pad") + (found.words.empty() ? "" : ": " + found.words) +
               (is_list ? "" : " in " + pads);
  for (FoundPad& one : found.pads) {
    std::vector<int>& tools = one.pad.settings.tools;
    if (tools.empty()) one.pad.settings.inspections = machine.walk.inspections;
    if (choice.vision_tool) {
      tools = {*choice.vision_tool};
    } else if (tools.empty()) {
      const std::optional<int> tool = tool_for(one.diameter, machine);
      if (!tool) {
        return failure(usage_of(
            list.file,
            one.pad.line,
            machine.vision_tools.empty()
                ? "machine.toml has no [[vision.tool]] for the pads"
                : fmt::format(
                      "it is open which [[vision.tool]] looks for pads{}",
                      one.diameter ? fmt::format(" of {:.3f} mm", one.diameter->in_mm()) : ""),
            "--tool with its number"));
      }
      tools = {*tool};
    }
    list.pads.push_back(std::move(one.pad));
  }
  PANELCAL_CHECK(check_places(list));
  return list;
}

namespace {

/// Lines that bring the camera's settings from one pad's to the next.
std::string setting_lines(const VisionSettings& now, const VisionSettings& next) {
  std::string lines;
  if (now.tools != next.tools || now.delta != next.delta) {
    lines += "G34";
    for (const int tool : next.tools) lines += fmt::format(",{}", tool);
    if (next.delta) lines += fmt::format(",{:.9f}", next.delta->in_mm());
    lines += "\n";
  }
  const auto state = [&](const char* key, const auto& before, const auto& after) {
    if (after && before != after) lines += fmt::format("$uvis,{},{}\n", key, *after);
  };
  if (now.inspections != next.inspections)
    lines += fmt::format("$uvis,insp,{}\n", next.inspections);
  if (next.search && now.search != next.search) {
    lines += fmt::format("$uvis,search,{}\n", *next.search ? "on" : "off");
  }
  if (next.search_area && now.search_area != next.search_area) {
    lines += fmt::format("$uvis,searcharea,{}\n", next.search_area->in_mm());
  }
  state("lamp", now.lamp, next.lamp);
  state("zoom", now.zoom, next.zoom);
  return lines;
}

}  // namespace

std::string pad_program(const std::vector<Pad>& pads) {
  std::string text = "M48\nMETRIC,TZ\nVER,1\n%\n";
  VisionSettings settings;
  // States the machine's own number, whatever it is.
  settings.inspections = 0;
  for (const Pad& pad : pads) {
    text += setting_lines(settings, pad.settings);
    settings = pad.settings;
    text += fmt::format("G36X{:.9f}Y{:.9f}\n", pad.nominal.in_mm().x(), pad.nominal.in_mm().y());
  }
  if (!pads.empty() && pads.front().settings.algorithm) {
    // `$uvis,alg` also counts the series, so that it stands before the first target.
    text.insert(text.find("G36"),
                fmt::format("$uvis,alg,{},{}\n", *pads.front().settings.algorithm, pads.size()));
  }
  return text + "M30\n";
}

}  // namespace panelcal
