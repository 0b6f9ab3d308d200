// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/advice/convex_hull.h"
#include "calib/base/files/atomic_file.h"
#include "surface/map/file.h"
#include "tools/surface/commands/grid.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/made_facts.h"
#include "tools/surface/shapes.h"
#include "tools/surface/text.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

const std::string kSurfaceQuery = "panelcal surface query";
constexpr std::size_t kMaxInputBytes = std::size_t{1} << 28;
/// Farther away no panel lies: a wrong unit.
constexpr double kMaxQueryPlace_mm = 1e6;

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
  return is_all && std::abs(value) <= kMaxQueryPlace_mm ? std::optional(value) : std::nullopt;
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
  return {Code::Usage, std::move(where), quoted(text) + " is not a place", "X,Y in mm"};
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

Expected<std::vector<Asked>> grid_places(const std::string& text, const ZonedMap& map) {
  PANELCAL_TRY(const GridAxes axes, grid_axes(kSurfaceQuery, text, map));
  std::vector<Asked> out;
  for (int j = 0; j < axes.y.n_nodes; ++j) {
    for (int i = 0; i < axes.x.n_nodes; ++i) {
      out.push_back({position_mm<frame::Nominal>(axes.x.at_mm(i), axes.y.at_mm(j)), std::nullopt});
    }
  }
  return out;
}

Expected<std::vector<Asked>> all_asked(const SurfaceOptions& options,
                                       const ZonedMap& map,
                                       CommandContext& context) {
  if (!options.grid.empty()) return grid_places(options.grid, map);
  std::vector<Asked> out;
  if (!options.program.empty()) {
    PANELCAL_TRY(const ProgramPlaces of, program_places(options, context));
    for (const plan::PlannedPlace& place : of.places) out.push_back({place.nominal, place});
    return out;
  }
  if (options.places.size() == 1 && options.places.front() == "-") {
    PANELCAL_TRY(const std::string text, read_file("/dev/stdin", kMaxInputBytes));
    return read_places(text);
  }
  for (const std::string& text : options.places) {
    const auto place = place_of(text);
    if (!place) return failure(no_place({kSurfaceQuery, 0, 0}, text));
    out.push_back({*place, std::nullopt});
  }
  if (!out.empty()) return out;
  return failure(usage(kSurfaceQuery, "no place is asked for", "X,Y, -, --program or --grid"));
}

/// Answer of a map.
struct Found {
  std::optional<ZonedHeight> height;  ///< empty: refused
  std::optional<std::string> zone;    ///< empty: in none, or there are none
  std::optional<Length> outside;      ///< of the zone's probes; empty: in no zone
};

Found ask(const ZonedMap& map, const Position<frame::Nominal>& place) {
  Found out;
  const auto zone = map.zone_at(place);
  if (!zone) return out;
  if (!map.zones().empty()) out.zone = map.zones()[*zone].name;
  if (auto height = map.height_at(place)) out.height = *std::move(height);
  out.outside =
      out.height ? out.height->height.outside : distance_outside(map.map(*zone).hull(), place);
  return out;
}

/// Columns of a table; those of programs, zones and voids only where there are any.
class QueryTable {
 public:
  void add(const Asked& asked, const Found& found) {
    const HeightAt height = found.height ? found.height->height : HeightAt{};
    x_mm_.push_back(asked.place.in_mm().x());
    y_mm_.push_back(asked.place.in_mm().y());
    height_mm_.push_back(found.height ? height.height.in_mm() : kNone);
    sigma_um_.push_back(found.height ? height.sigma.in_um() : kNone);
    outside_mm_.push_back(found.outside ? found.outside->in_mm() : kNone);
    source_.emplace_back(found.height ? source_word(height.source) : "refused");
    zone_.push_back(found.zone.value_or(""));
    void_.push_back(found.height ? found.height->in_void : "");
    if (!asked.from) return;
    line_.push_back(static_cast<std::uint32_t>(asked.from->line));
    tool_.push_back(static_cast<std::uint32_t>(asked.from->tool));
    file_.push_back(asked.from->file);
    path_.push_back(fmt::format("{}", fmt::join(asked.from->path, ",")));
  }

  facts::Json facts(const ZonedMap& map) const {
    facts::Json out = {{"x_mm", column(x_mm_)},
                       {"y_mm", column(y_mm_)},
                       {"height_mm", column(height_mm_)},
                       {"sigma_um", column(sigma_um_)},
                       {"outside_mm", column(outside_mm_)},
                       {"source", word_column(source_)}};
    if (!map.zones().empty()) out["zone"] = word_column(zone_);
    if (!map.voids().all().empty()) out["void"] = word_column(void_);
    if (line_.empty()) return out;
    out["line"] = column(line_);
    out["tool"] = column(tool_);
    out["file"] = word_column(file_);
    out["path"] = word_column(path_);
    return out;
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::vector<double> x_mm_, y_mm_, height_mm_, sigma_um_, outside_mm_;
  std::vector<std::uint32_t> line_, tool_;
  std::vector<std::string> source_, zone_, void_, file_, path_;
};

std::string text_line(const Asked& asked, const Found& found) {
  std::string out = fmt::format("{:<24}", place_text(asked.place));
  if (found.height) {
    const HeightAt& height = found.height->height;
    out += fmt::format("{:9.4f} mm +- {:<9} {}",
                       height.height.in_mm(),
                       um_text(height.sigma),
                       source_word(height.source));
    if (!found.height->in_void.empty()) out += ": " + found.height->in_void;
  } else {
    out += "  refused";
  }
  if (!found.outside) out += ", in no zone";
  if (found.zone) out += ", zone " + quoted(*found.zone);
  if (found.outside && *found.outside > mm(0)) {
    out += fmt::format(", {:.3f} mm outside of the probes", found.outside->in_mm());
  }
  if (asked.from) {
    out += fmt::format(
        ", {}line {}", asked.from->file.empty() ? "" : asked.from->file + " ", asked.from->line);
  }
  return out + "\n";
}

std::string refused_text(std::size_t n_refused, std::size_t n_asked, const ZonedMap& map) {
  std::string why = "outside of all zones, or farther outside of the probes than their zone allows";
  if (map.zones().empty()) {
    why = fmt::format("farther outside of the probes than {:g} mm",
                      map.map(0).options().max_extrapolation.in_mm());
  }
  return fmt::format("{} of {} refused: {}", n_refused, amount(n_asked, "place"), why);
}

}  // namespace

Expected<Answer> query(const SurfaceOptions& options, CommandContext& context) {
  PANELCAL_TRY(const StoredZones stored, read_zoned_map_file(options.map));
  PANELCAL_TRY(const std::vector<Asked> asked, all_asked(options, stored.map, context));
  Answer answer;
  QueryTable table;
  std::size_t n_refused = 0;
  for (const Asked& place : asked) {
    const Found found = ask(stored.map, place.place);
    if (!found.height) ++n_refused;
    if (options.facts.json != "-") answer.text += text_line(place, found);
    if (!options.facts.json.empty()) table.add(place, found);
  }
  const auto document = [&] {
    facts::Json out = surface_envelope("query");
    out["map"] = options.map;
    out["refused"] = n_refused;
    out["places"] = table.facts(stored.map);
    out["provenance"] = provenance_facts(provenance_of(
        context, std::vector<std::string>{options.map, options.program, options.machine}));
    return facts::text(out);
  };
  if (n_refused > 0) {
    answer.code = ExitCode::GateFailed;
    context.console.say(refused_text(n_refused, asked.size(), stored.map));
  }
  return state_facts(context, options.facts, {}, document, std::move(answer));
}

}  // namespace panelcal::surface
