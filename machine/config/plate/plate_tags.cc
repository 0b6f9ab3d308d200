// SPDX-License-Identifier: Apache-2.0
#include "machine/config/plate/plate_tags.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "machine/config/toml/ranges.h"
#include "vision/tag/family.h"
#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 9> kTagsKeys = {"angle_deg",
                                                       "columns",
                                                       "family",
                                                       "first_cell",
                                                       "first_id",
                                                       "polarity",
                                                       "rows",
                                                       "size_mm",
                                                       "step_cells"};
constexpr std::array<std::string_view, 3> kTagKeys = {"angle_deg", "cell", "id"};
/// More add nothing, and every pair is compared.
constexpr int kMaxTagsPerSide = 100;
constexpr std::size_t kMostTags = 2000;
constexpr Range kCells{-1000, 1000};
constexpr Range kStep_cells{0, 1000, true};
constexpr Range kAngle_deg{-360, 360};

/// Puts tags on the plate.
class TagsReader {
 public:
  TagsReader(const TomlTable& tags, Length pitch) : table_(tags), pitch_(pitch) {}

  Expected<void> read_look() {
    PANELCAL_TRY(const auto family, table_.text("family"));
    if (family) out_.family = *family;
    const auto known = find_tag_family(out_.family);
    if (!known) {
      return failure(
          table_.problem("family", fmt::format("one of {}", fmt::join(tag_family_names(), ", "))));
    }
    n_ids_ = known->n_tags();
    PANELCAL_TRY(const auto size_mm, table_.number("size_mm", {0, kMaxPlace_mm, true}));
    if (!size_mm) return failure(table_.missing("size_mm", "the side between a tag's corners"));
    out_.size = mm(*size_mm);
    PANELCAL_TRY(const auto polarity, table_.text("polarity"));
    if (!polarity) return {};
    const auto word = polarity_from_name(*polarity);
    if (!word) return failure(table_.problem("polarity", "\"bright\" or \"dark\""));
    out_.polarity = *word;
    return {};
  }

  /// Tags in columns and rows, their ids counted along x first.
  Expected<void> read_lattice() {
    PANELCAL_TRY(const auto columns, table_.integer("columns", 1, kMaxTagsPerSide));
    PANELCAL_TRY(const auto rows, table_.integer("rows", 1, kMaxTagsPerSide));
    PANELCAL_TRY(const auto first_id, table_.integer("first_id", 0, kMaxTagId));
    PANELCAL_TRY(const auto first_cell, table_.pair("first_cell", kCells));
    PANELCAL_TRY(const auto step_cells, table_.pair("step_cells", kStep_cells));
    PANELCAL_TRY(const double angle_deg, table_.number_or("angle_deg", kAngle_deg, 0));
    if (!columns && !rows) {
      return check_nothing_else({"angle_deg", "first_cell", "first_id", "step_cells"});
    }
    if (!columns) return failure(table_.missing("columns", "columns beside rows"));
    if (!rows) return failure(table_.missing("rows", "rows beside columns"));
    if (!first_cell) {
      return failure(table_.missing("first_cell", "the first tag's middle, [column, row]"));
    }
    if (!step_cells && *columns * *rows > 1) {
      return failure(table_.missing("step_cells", "pitches from tag to tag, [along x, along y]"));
    }
    const Eigen::Vector2d step = step_cells.value_or(Eigen::Vector2d::Ones());
    int id = static_cast<int>(first_id.value_or(0));
    for (int row = 0; row < *rows; ++row) {
      for (int column = 0; column < *columns; ++column) {
        const Eigen::Vector2d cell = *first_cell + step.cwiseProduct(Eigen::Vector2d(column, row));
        PANELCAL_CHECK(add(table_,
                           table_.has("first_id") ? "first_id" : "columns",
                           "step_cells",
                           {id++, place_of(cell), deg(angle_deg)}));
      }
    }
    return {};
  }

  Expected<void> read_one(const TomlTable& table) {
    PANELCAL_TRY(const auto id, table.integer("id", 0, kMaxTagId));
    if (!id) return failure(table.missing("id", "id = 5, the tag's number in its family"));
    PANELCAL_TRY(const auto cell, table.pair("cell", kCells));
    if (!cell) return failure(table.missing("cell", "the tag's middle, [column, row]"));
    PANELCAL_TRY(const double angle_deg, table.number_or("angle_deg", kAngle_deg, 0));
    return add(table, "id", "cell", {static_cast<int>(*id), place_of(*cell), deg(angle_deg)});
  }

  Expected<PlateTags> result() {
    if (!out_.tags.empty()) return std::move(out_);
    return failure(table_.missing("tags", "columns, rows, first_cell, step_cells; or [[tag]]"));
  }

 private:
  Position<frame::Plate> place_of(const Eigen::Vector2d& cell) const {
    return position_mm<frame::Plate>((pitch_.in_mm() * cell).eval());
  }

  /// Keys of a lattice that is not there.
  Expected<void> check_nothing_else(const std::array<std::string_view, 4>& keys) const {
    for (const std::string_view key : keys) {
      if (table_.has(key)) return failure(table_.problem(key, "columns and rows beside it"));
    }
    return {};
  }

  /// Takes a tag; a problem is reported at the key of its id or of its place.
  Expected<void> add(const TomlTable& table,
                     std::string_view id_key,
                     std::string_view place_key,
                     const PlateTag& tag) {
    if (tag.id >= n_ids_) {
      return failure(table.problem(id_key,
                                   fmt::format("ids up to {}", n_ids_ - 1),
                                   fmt::format("{} has no tag {}", out_.family, tag.id)));
    }
    if (out_.tags.size() >= kMostTags) {
      return failure(table.problem(id_key, fmt::format("at most {} tags", kMostTags)));
    }
    for (const PlateTag& other : out_.tags) {
      if (other.id == tag.id) {
        return failure(table.problem(
            id_key, "every id once", fmt::format("tag {} is on the plate already", tag.id)));
      }
      // However they are turned, nearer ones overlap.
      if ((other.center - tag.center).in_mm().norm() < out_.size.in_mm()) {
        return failure(table.problem(place_key,
                                     "places farther apart than size_mm",
                                     fmt::format("tags {} and {} overlap", other.id, tag.id)));
      }
    }
    out_.tags.push_back(tag);
    return {};
  }

  const TomlTable& table_;
  Length pitch_;
  int n_ids_ = 0;
  PlateTags out_;
};

}  // namespace

Expected<std::optional<PlateTags>> read_plate_tags(const TomlTable& top, Length pitch) {
  PANELCAL_TRY(const auto table, top.table("tags", "[tags]", {kTagsKeys, {}}));
  PANELCAL_TRY(const auto ones, top.tables("tag", "[[tag]]", {kTagKeys, {}}));
  if (!table && ones.empty()) return std::nullopt;
  if (!table) return failure(top.missing("[tags] beside [[tag]]", "[tags] family, size_mm"));
  TagsReader reader(*table, pitch);
  PANELCAL_CHECK(reader.read_look());
  PANELCAL_CHECK(reader.read_lattice());
  for (const TomlTable& one : ones) PANELCAL_CHECK(reader.read_one(one));
  PANELCAL_TRY(PlateTags tags, reader.result());
  return tags;
}

}  // namespace panelcal::internal
