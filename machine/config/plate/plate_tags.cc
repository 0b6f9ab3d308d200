// SPDX-License-Identifier: Apache-2.0
#include "machine/config/plate/plate_tags.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "calib/base/fields/slots.h"
#include "machine/config/toml/ranges.h"
#include "vision/tag/family.h"
#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

/// More add nothing, and every pair is compared.
constexpr WholeRange kTagsPerSide{1, 100};
constexpr std::size_t kMostTags = 2000;
constexpr Range kCells{-1000, 1000};
constexpr Range kStep_cells{0, 1000, true};
constexpr Range kAngle_deg{-360, 360};

/// [tags]: the look of all, and a lattice of some.
struct TagsKeys {
  PlateTags look;
  std::optional<int> columns;
  std::optional<int> rows;
  int first_id = 0;
  std::optional<Eigen::Vector2d> first_cell;
  std::optional<Eigen::Vector2d> step_cells;
  Angle angle;
};

/// A row of [[tag]].
struct TagKeys {
  int id = 0;
  Eigen::Vector2d cell = Eigen::Vector2d::Zero();
  Angle angle;
};

#include "machine/config/plate/plate_tags.def"

/// Puts tags on the plate.
class TagsReader {
 public:
  TagsReader(const TomlTable& tags, Length pitch) : table_(tags), pitch_(pitch) {}

  Expected<void> read() {
    TagsKeys keys;
    PANELCAL_CHECK(table_.read(kTags, keys));
    out_ = keys.look;
    const auto known = find_tag_family(out_.family);
    if (!known) {
      return failure(
          table_.problem("family", fmt::format("one of {}", fmt::join(tag_family_names(), ", "))));
    }
    n_ids_ = known->n_tags();
    return add_lattice(keys);
  }

  Expected<void> read_one(const TomlTable& table) {
    TagKeys keys;
    PANELCAL_CHECK(table.read(kTag, keys));
    return add(table, "id", "cell", {keys.id, place_of(keys.cell), keys.angle});
  }

  Expected<PlateTags> result() {
    if (!out_.tags.empty()) return std::move(out_);
    return failure(table_.missing("tags", "columns, rows, first_cell, step_cells; or [[tag]]"));
  }

 private:
  Position<frame::Plate> place_of(const Eigen::Vector2d& cell) const {
    return position_mm<frame::Plate>((pitch_.in_mm() * cell).eval());
  }

  /// Tags in columns and rows, their ids counted along x first.
  Expected<void> add_lattice(const TagsKeys& keys) {
    if (!keys.columns && !keys.rows) return check_nothing_else();
    if (!keys.columns) return failure(table_.missing("columns", "columns beside rows"));
    if (!keys.rows) return failure(table_.missing("rows", "rows beside columns"));
    if (!keys.first_cell) {
      return failure(table_.missing("first_cell", "the first tag's middle, [column, row]"));
    }
    if (!keys.step_cells && *keys.columns * *keys.rows > 1) {
      return failure(table_.missing("step_cells", "pitches from tag to tag, [along x, along y]"));
    }
    const Eigen::Vector2d step = keys.step_cells.value_or(Eigen::Vector2d::Ones());
    int id = keys.first_id;
    for (int row = 0; row < *keys.rows; ++row) {
      for (int column = 0; column < *keys.columns; ++column) {
        const Eigen::Vector2d cell =
            *keys.first_cell + step.cwiseProduct(Eigen::Vector2d(column, row));
        PANELCAL_CHECK(add(table_,
                           table_.has("first_id") ? "first_id" : "columns",
                           "step_cells",
                           {id++, place_of(cell), keys.angle}));
      }
    }
    return {};
  }

  /// Keys of a lattice that is not there.
  Expected<void> check_nothing_else() const {
    for (const std::string_view key : {"angle_deg", "first_cell", "first_id", "step_cells"}) {
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

Tables plate_tag_tables() {
  return kPlateTagTables;
}

Expected<std::optional<PlateTags>> read_plate_tags(const TomlTable& top, Length pitch) {
  PANELCAL_TRY(const auto table, top.table(kTags));
  PANELCAL_TRY(const auto ones, top.tables(kTag));
  if (!table && ones.empty()) return std::nullopt;
  if (!table) return failure(top.missing("[tags] beside [[tag]]", "[tags] family, size_mm"));
  TagsReader reader(*table, pitch);
  PANELCAL_CHECK(reader.read());
  for (const TomlTable& one : ones) PANELCAL_CHECK(reader.read_one(one));
  PANELCAL_TRY(PlateTags tags, reader.result());
  return tags;
}

}  // namespace panelcal::internal
