// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/convex_hull.h"
#include "panelcal/program/json_text.h"
#include "panelcal/surface/map_file.h"
#include "panelcal/tools/surface_command.h"
#include "panelcal/tools/surface_grid.h"
#include "panelcal/tools/surface_text.h"

namespace panelcal::surface {
namespace {

const std::string kCommand = "panelcal surface query";
constexpr std::size_t kMaxInputBytes = std::size_t{1} << 28;
/// Farther away no panel lies: a wrong unit.
constexpr double kMost_mm = 1e6;

/// A place that is asked for, and who asks.
struct Asked {
  Position<frame::Nominal> place;
  std::optional<plan::PlannedPlace> from;
};

/// A finite number that is all of the text.
std::optional<double> number_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_all = read.ec == std::errc() && read.ptr == text.data() + text.size();
  return is_all && std::abs(value) <= kMost_mm ? std::optional(value) : std::nullopt;
}

/// "X,Y", or with blanks between.
std::optional<Position<frame::Nominal>> place_of(std::string_view text) {
  constexpr std::string_view kBetween = ", \t";
  const std::size_t end = text.find_first_of(kBetween);
  if (end == std::string_view::npos) return std::nullopt;
  std::size_t next = text.find_first_not_of(" \t", end);
  if (next != std::string_view::npos && text[next] == ',') {
    next = text.find_first_not_of(" \t", next + 1);
  }
  if (next == std::string_view::npos) return std::nullopt;
  const auto x_mm = number_of(text.substr(0, end)), y_mm = number_of(text.substr(next));
  if (!x_mm || !y_mm) return std::nullopt;
  return position_mm<frame::Nominal>(*x_mm, *y_mm);
}

Diagnostic no_place(Place where, std::string_view text) {
  return {Code::Usage, std::move(where), quoted(text) + " is no place", "X,Y in mm"};
}

Expected<std::vector<Asked>> read_places(std::string_view text) {
  std::vector<Asked> out;
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = text.find('\n');
    std::string_view row = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    const std::size_t first = row.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) continue;
    row = row.substr(first, row.find_last_not_of(" \t\r") + 1 - first);
    const auto place = place_of(row);
    if (!place) return failure(no_place({"<stdin>", line, static_cast<int>(first) + 1}, row));
    out.push_back({*place, std::nullopt});
  }
  return out;
}

Expected<std::vector<Asked>> grid_places(const std::string& text, const HeightMap& map) {
  PANELCAL_TRY(const GridAxes axes, grid_axes(kCommand, text, map));
  std::vector<Asked> out;
  for (int j = 0; j < axes.y.n_nodes; ++j) {
    for (int i = 0; i < axes.x.n_nodes; ++i) {
      out.push_back({position_mm<frame::Nominal>(axes.x.at_mm(i), axes.y.at_mm(j)), std::nullopt});
    }
  }
  return out;
}

Expected<std::vector<Asked>> all_asked(const SurfaceOptions& options,
                                       const HeightMap& map,
                                       CommandContext& context) {
  if (!options.grid.empty()) return grid_places(options.grid, map);
  std::vector<Asked> out;
  if (!options.program.empty()) {
    PANELCAL_TRY(const auto places, program_places(options, context));
    for (const plan::PlannedPlace& place : places) out.push_back({place.nominal, place});
    return out;
  }
  if (options.places.size() == 1 && options.places.front() == "-") {
    PANELCAL_TRY(const std::string text, read_file("/dev/stdin", kMaxInputBytes));
    return read_places(text);
  }
  for (const std::string& text : options.places) {
    const auto place = place_of(text);
    if (!place) return failure(no_place({kCommand, 0, 0}, text));
    out.push_back({*place, std::nullopt});
  }
  if (!out.empty()) return out;
  return failure(usage(kCommand, "no place is asked for", "X,Y, -, --program or --grid"));
}

std::string_view word(HeightSource source) {
  switch (source) {
    case HeightSource::Measured:
      return "measured";
    case HeightSource::Filled:
      return "filled";
    case HeightSource::InVoid:
      return "void";
    case HeightSource::Extrapolated:
      break;
  }
  return "extrapolated";
}

std::string json_line(const Asked& asked, const Expected<HeightAt>& found, Length outside) {
  std::string out =
      fmt::format(R"({{"place":[{},{}])", asked.place.in_mm().x(), asked.place.in_mm().y());
  if (asked.from) {
    out += fmt::format(R"(,"line":{})", asked.from->line);
    if (!asked.from->file.empty()) {
      out += ",\"file\":";
      append_json_string(out, asked.from->file);
    }
    if (asked.from->tool > 0) out += fmt::format(R"(,"tool":{})", asked.from->tool);
    out += fmt::format(R"(,"path":[{}])", fmt::join(asked.from->path, ","));
  }
  if (found) {
    out += fmt::format(R"(,"height":{},"sigma":{},"source":"{}")",
                       found->height.in_mm(),
                       found->sigma.in_mm(),
                       word(found->source));
  } else {
    out += R"(,"source":"refused")";
  }
  return out + fmt::format(",\"outside\":{}}}\n", outside.in_mm());
}

std::string text_line(const Asked& asked, const Expected<HeightAt>& found, Length outside) {
  std::string out = fmt::format("{:<24}", place_text(asked.place));
  if (found) {
    out += fmt::format("{:9.4f} mm +- {:<9} {}",
                       found->height.in_mm(),
                       um_text(found->sigma),
                       word(found->source));
  } else {
    out += "  refused";
  }
  if (outside > mm(0)) out += fmt::format(", {:.3f} mm outside of the probes", outside.in_mm());
  if (asked.from) {
    out += fmt::format(
        ", {}line {}", asked.from->file.empty() ? "" : asked.from->file + " ", asked.from->line);
  }
  return out + "\n";
}

}  // namespace

Expected<Answer> query(const SurfaceOptions& options, CommandContext& context) {
  PANELCAL_TRY(const StoredMap stored, read_map_file(options.map));
  const HeightMap& map = stored.map;
  PANELCAL_TRY(const std::vector<Asked> asked, all_asked(options, map, context));
  const std::vector<Position<frame::Nominal>> hull(map.hull().begin(), map.hull().end());
  Answer answer;
  std::size_t n_refused = 0;
  for (const Asked& place : asked) {
    const Expected<HeightAt> found = map.height_at(place.place);
    const Length outside = found ? found->outside : distance_outside(hull, place.place);
    if (!found) ++n_refused;
    answer.text +=
        options.json ? json_line(place, found, outside) : text_line(place, found, outside);
  }
  if (n_refused > 0) {
    answer.code = ExitCode::GateFailed;
    context.console.say(fmt::format("{} of {} refused: farther outside of the probes than {:g} mm",
                                    n_refused,
                                    amount(asked.size(), "place"),
                                    map.options().max_extrapolation.in_mm()));
  }
  return answer;
}

}  // namespace panelcal::surface
