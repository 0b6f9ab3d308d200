// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/json/strict_json.h"
#include "surface/files/formats/json_places.h"
#include "surface/files/formats/klipper_mesh.h"
#include "surface/files/probe_readers.h"
#include "surface/files/probe_signs.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

std::string_view unquoted(std::string_view text) {
  return text.size() >= 2 && text.starts_with('"') ? text.substr(1, text.size() - 2) : text;
}

/// `bed_mesh` within an answer of Moonraker, or the document if it is that itself.
std::string_view bed_mesh_of(std::string_view document) {
  std::string_view inner = document;
  for (const std::string_view key : {"result", "status", "bed_mesh"}) {
    const std::string_view member = JsonPlaces::member(inner, key);
    if (!member.empty()) inner = member;
  }
  return inner;
}

class MoonrakerReader {
 public:
  MoonrakerReader(std::string_view text, const std::string& file) : places_(text), file_(file) {}

  /// In     is_loaded: the mesh that is loaded counts, if there is one
  Expected<void> read(bool is_loaded) {
    const std::string_view mesh = bed_mesh_of(places_.document());
    for (const auto& [name, profile] : JsonPlaces::members(JsonPlaces::member(mesh, "profiles"))) {
      KlipperProfile read{places_.field(name), {}, rows_of(JsonPlaces::member(profile, "points"))};
      for (const auto& [key, value] :
           JsonPlaces::members(JsonPlaces::member(profile, "mesh_params"))) {
        read.values.emplace(std::string(key), places_.field(value));
      }
      profiles_.push_back(std::move(read));
    }
    const auto rows = rows_of(JsonPlaces::member(mesh, "probed_matrix"));
    const bool is_active = is_loaded && !rows.empty() && !rows.front().empty();
    return is_active ? read_active(mesh, rows) : Expected<void>{};
  }

  const std::vector<KlipperProfile>& profiles() const { return profiles_; }
  const std::optional<KlipperProfile>& active() const { return active_; }

 private:
  std::vector<std::vector<TextField>> rows_of(std::string_view matrix) const {
    std::vector<std::vector<TextField>> out;
    for (const std::string_view row : JsonPlaces::elements(matrix)) {
      out.emplace_back();
      for (const std::string_view cell : JsonPlaces::elements(row)) {
        out.back().push_back(places_.field(cell));
      }
    }
    return out;
  }

  /// The mesh that is loaded: places stand in mesh_min and mesh_max, counts are the matrix's.
  Expected<void> read_active(std::string_view mesh,
                             const std::vector<std::vector<TextField>>& rows) {
    const TextField matrix = places_.field(JsonPlaces::member(mesh, "probed_matrix"));
    const std::string_view name = unquoted(JsonPlaces::member(mesh, "profile_name"));
    KlipperProfile active{
        name.empty() ? TextField{"", matrix.line, matrix.column} : places_.field(name), {}, rows};
    for (const auto& [key, low_or_high] :
         {std::pair("mesh_min", "min_"), std::pair("mesh_max", "max_")}) {
      const std::string_view value = JsonPlaces::member(mesh, key);
      const auto pair = JsonPlaces::elements(value);
      if (pair.size() != 2) {
        const TextField at = value.empty() ? matrix : places_.field(value);
        return failure({Code::MeasurementFile,
                        {file_, at.line, at.column},
                        fmt::format("a probed_matrix without {}", key),
                        "[x, y] of it"});
      }
      active.values.emplace(std::string(low_or_high) + "x", places_.field(pair[0]));
      active.values.emplace(std::string(low_or_high) + "y", places_.field(pair[1]));
    }
    counts_ = {std::to_string(rows.front().size()), std::to_string(rows.size())};
    active.values.emplace("x_count", TextField{counts_[0], matrix.line, matrix.column});
    active.values.emplace("y_count", TextField{counts_[1], matrix.line, matrix.column});
    for (const KlipperProfile& profile : profiles_) {
      if (name.empty() || profile.name.text != name || are_same(profile, active)) continue;
      return failure({Code::MeasurementFile,
                      {file_, matrix.line, matrix.column},
                      fmt::format("a probed_matrix that is not the profile {}", quoted(name)),
                      "the same heights: save or load the mesh first"});
    }
    active_ = std::move(active);
    return {};
  }

  static bool are_same(const KlipperProfile& a, const KlipperProfile& b) {
    const auto is_same = [](const TextField& p, const TextField& q) { return p.text == q.text; };
    return std::ranges::equal(a.rows, b.rows, [&](const auto& p, const auto& q) {
      return std::ranges::equal(p, q, is_same);
    });
  }

  JsonPlaces places_;
  const std::string& file_;
  std::vector<KlipperProfile> profiles_;
  std::optional<KlipperProfile> active_;
  std::array<std::string, 2> counts_;
};

}  // namespace

bool is_moonraker_json(std::string_view text) {
  const auto has = [&](std::string_view word) { return text.find(word) != std::string_view::npos; };
  return text.starts_with('{') &&
         (has("\"bed_mesh\"") || has("\"probed_matrix\"") || has("\"mesh_params\""));
}

Expected<ProbeFile> parse_moonraker_json(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options) {
  PANELCAL_CHECK(parse_strict_json(text, file));
  MoonrakerReader reader(text, file);
  PANELCAL_CHECK(reader.read(options.profile.empty()));
  KlipperBed bed;
  bed.may_be_round = true;
  bed.zero = "its nozzle at Z 0, or those at its zero_reference_position";
  if (reader.active()) {
    return file_of_profile(ProbeFormat::MoonrakerJson, file, *reader.active(), bed, options);
  }
  PANELCAL_TRY(const KlipperProfile* const profile,
               chosen_profile(reader.profiles(), file, options));
  return file_of_profile(ProbeFormat::MoonrakerJson, file, *profile, bed, options);
}

}  // namespace panelcal::internal
