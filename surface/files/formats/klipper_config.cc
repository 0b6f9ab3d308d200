// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "surface/files/formats/klipper_mesh.h"
#include "surface/files/probe_readers.h"
#include "surface/files/probe_signs.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Ahead of each line that SAVE_CONFIG wrote.
constexpr std::string_view kAutosaved = "#*#";
constexpr std::string_view kBedMesh = "bed_mesh";
constexpr std::array<std::string_view, 11> kProfileKeys = {"version",
                                                           "points",
                                                           "x_count",
                                                           "y_count",
                                                           "min_x",
                                                           "max_x",
                                                           "min_y",
                                                           "max_y",
                                                           "mesh_x_pps",
                                                           "mesh_y_pps",
                                                           "algo"};

/// A line without the mark of SAVE_CONFIG and without comments; blanks ahead of it stay.
TextField config_text(const TextField& line) {
  TextField out = line;
  if (out.text.starts_with(kAutosaved)) {
    out = part_of(out, kAutosaved.size());
    if (out.text.starts_with(' ')) out = part_of(out, 1);
  }
  const std::size_t comment = out.text.find_first_of("#;");
  const bool is_comment =
      comment == 0 || (comment != std::string_view::npos &&
                       (out.text[comment - 1] == ' ' || out.text[comment - 1] == '\t'));
  return is_comment ? part_of(out, 0, comment) : out;
}

class KlipperConfigReader {
 public:
  KlipperConfigReader(std::string_view text, const std::string& file)
      : lines_(text, file), file_(file) {}

  Expected<void> read() {
    while (true) {
      PANELCAL_TRY(const std::optional<TextField> line, lines_.next());
      if (!line) return {};
      const TextField text = config_text(*line);
      if (trimmed(text).text.empty()) continue;
      if (text.text.starts_with('[')) {
        PANELCAL_CHECK(start_section(text));
      } else if (section_ != Section::Other) {
        const bool is_continued = text.text.starts_with(' ') || text.text.starts_with('\t');
        PANELCAL_CHECK(is_continued ? continue_value(trimmed(text)) : read_key(text));
      }
    }
  }

  const std::vector<KlipperProfile>& profiles() const { return profiles_; }
  const KlipperBed& bed() const { return bed_; }

 private:
  enum class Section { Other, Bed, Profile };

  Expected<void> start_section(const TextField& text) {
    section_ = Section::Other;
    key_.clear();
    const std::size_t end = text.text.find(']');
    const TextField name = trimmed(part_of(text, 1, end));
    if (!name.text.starts_with(kBedMesh)) return {};
    if (end == std::string_view::npos) return failure(unexpected_field(file_, text, "\"]\""));
    const TextField profile = trimmed(part_of(name, kBedMesh.size()));
    if (profile.text.empty()) {
      section_ = Section::Bed;
      return {};
    }
    // Another section whose name only begins so.
    if (profile.column == name.column + static_cast<int>(kBedMesh.size())) return {};
    for (const KlipperProfile& other : profiles_) {
      if (other.name.text != profile.text) continue;
      return failure(unexpected_field(
          file_, profile, fmt::format("each mesh once; line {} has this one", other.name.line)));
    }
    section_ = Section::Profile;
    profiles_.push_back({profile, {}, {}});
    return {};
  }

  Expected<void> read_key(const TextField& text) {
    const std::size_t sign = text.text.find_first_of("=:");
    if (sign == std::string_view::npos) {
      return failure(unexpected_field(file_, text, "a key and its value"));
    }
    const TextField key = trimmed(part_of(text, 0, sign));
    const TextField value = trimmed(part_of(text, sign + 1));
    key_ = key.text;
    if (section_ == Section::Bed) return read_bed(key, value);
    KlipperProfile& profile = profiles_.back();
    const bool is_known =
        std::ranges::find(kProfileKeys, key.text) != kProfileKeys.end() || key.text == "tension";
    if (!is_known) {
      return failure(unexpected_field(
          file_, key, fmt::format("{} or tension", fmt::join(kProfileKeys, ", "))));
    }
    if (!profile.values.emplace(key_, value).second) {
      return failure(unexpected_field(file_, key, "each key once"));
    }
    if (key_ == "version" && value.text != "1") return failure(unexpected_field(file_, value, "1"));
    if (key_ == "points" && !value.text.empty()) return continue_value(value);
    return {};
  }

  Expected<void> continue_value(const TextField& text) {
    if (section_ == Section::Bed) return {};
    if (key_ != "points") return failure(unexpected_field(file_, text, "a key and its value"));
    profiles_.back().rows.push_back(cells_of(text));
    return {};
  }

  Expected<Eigen::Vector2d> pair_of(const TextField& value) const {
    const auto cells = cells_of(value);
    if (cells.size() != 2) return failure(unexpected_field(file_, value, "x, y"));
    PANELCAL_TRY(const double x, number_of(file_, cells[0]));
    PANELCAL_TRY(const double y, number_of(file_, cells[1]));
    return Eigen::Vector2d(x, y);
  }

  /// Only what decides which heights are made up, and what is 0.
  Expected<void> read_bed(const TextField& key, const TextField& value) {
    constexpr std::string_view kFaulty = "faulty_region_";
    if (key.text == "mesh_radius") {
      PANELCAL_TRY(const double radius_mm, number_of(file_, value));
      bed_.radius_mm = radius_mm;
    } else if (key.text == "mesh_origin") {
      PANELCAL_TRY(bed_.origin_mm, pair_of(value));
    } else if (key.text == "zero_reference_position") {
      PANELCAL_TRY(const Eigen::Vector2d place_mm, pair_of(value));
      bed_.zero = fmt::format("that at ({:g}, {:g})", place_mm.x(), place_mm.y());
    } else if (key.text == "relative_reference_index") {
      bed_.zero = fmt::format("that of probe {}", value.text);
    } else if (key.text.starts_with(kFaulty)) {
      const bool is_low = key.text.ends_with("_min");
      if (!is_low && !key.text.ends_with("_max")) return {};
      PANELCAL_TRY(const Eigen::Vector2d place_mm, pair_of(value));
      const std::string name(key.text.substr(0, key.text.size() - 4));
      auto region = std::ranges::find(bed_.faulty, name, &KlipperBed::Region::name);
      if (region == bed_.faulty.end()) region = bed_.faulty.insert(region, {name, {}, {}});
      (is_low ? region->low_mm : region->high_mm) = place_mm;
    }
    return {};
  }

  TextLines lines_;
  const std::string& file_;
  Section section_ = Section::Other;
  std::string key_;
  std::vector<KlipperProfile> profiles_;
  KlipperBed bed_;
};

}  // namespace

bool is_klipper_config(std::string_view text) {
  for (std::size_t at = text.find("[bed_mesh"); at != std::string_view::npos;
       at = text.find("[bed_mesh", at + 1)) {
    const std::size_t line_break = text.substr(0, at).find_last_of("\r\n");
    const std::size_t begin = line_break == std::string_view::npos ? 0 : line_break + 1;
    const std::string_view ahead = text.substr(begin, at - begin);
    if (ahead.empty() || ahead == kAutosaved || ahead == "#*# ") return true;
  }
  return false;
}

Expected<ProbeFile> parse_klipper_config(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options) {
  KlipperConfigReader reader(text, file);
  PANELCAL_CHECK(reader.read());
  PANELCAL_CHECK(check_line_end(text, file));
  PANELCAL_TRY(const KlipperProfile* const profile,
               chosen_profile(reader.profiles(), file, options));
  return file_of_profile(ProbeFormat::KlipperConfig, file, *profile, reader.bed(), options);
}

}  // namespace panelcal::internal
