// SPDX-License-Identifier: Apache-2.0
// Depths and feeds of a tool: as the program says, else as [gcode] does, else not at all.

#include "program/writers/gcode/writer.h"
#include <fmt/format.h>

namespace panelcal {

/// The Z of the tool's tip. An offset of the tool comes to planes, not to depths below a surface.
std::optional<GcodeWriter::Steps> GcodeWriter::working_z(const DepthOfCut& cut,
                                                         const std::optional<Length>& plane,
                                                         const std::optional<Length>& offset,
                                                         std::string_view plane_key) {
  std::optional<Length> z = height_of(cut, plane, plane_key);
  if (!z || !surface_is_below(cut) || !serves_all_axes(cut)) return std::nullopt;
  if (!keeps_to_limits(cut, *z)) return std::nullopt;
  if (!cut.is_controlled() && offset) z = *z + *offset;
  if (!(*z < rapid_limit())) {
    refuse_unsaid(
        fmt::format("T{} would work at Z{:.4f}, where it moves rapidly", tool_.number, z->in_mm()),
        fmt::format("less than {} in [gcode]",
                    setting_.approach_z ? "approach_z_mm" : "safe_z_mm"));
    return std::nullopt;
  }
  return steps(z->in_mm());
}

std::optional<Length> GcodeWriter::height_of(const DepthOfCut& cut,
                                             const std::optional<Length>& plane,
                                             std::string_view plane_key) {
  if (cut.is_controlled() && !cut.depth) {
    refuse_unsaid(fmt::format("T{} works to a depth below the board that the operator sets ({} "
                              "without K#)",
                              tool_.number,
                              cut.control == DepthControl::Slm ? "G71" : "G83"),
                  "K# in the program, or [[depth]] in machine.toml");
    return std::nullopt;
  }
  const bool counts_from_table = cut.depth ? cut.surface.has_value() : cut.z.has_value();
  if (counts_from_table && !setting_.table_z) {
    refuse_unsaid(cut.depth ? "a surface is measured above the table plane, whose height is missing"
                            : "a plane (Z#) is above the table plane, whose height is missing",
                  "table_z_mm in [gcode]: 0 if the tool is zeroed on it");
    return std::nullopt;
  }
  if (cut.depth && cut.surface && *cut.surface < *cut.depth) {
    refuse(fmt::format("a depth of {:.4g} mm below a surface that is {:.4g} mm above the table, so "
                       "into the table",
                       cut.depth->in_mm(),
                       cut.surface->in_mm()),
           "heights of the board above the table, and depths that end in it");
    return std::nullopt;
  }
  if (counts_from_table) {
    return *setting_.table_z + (cut.depth ? *cut.surface - *cut.depth : *cut.z);
  }
  if (cut.depth && !setting_.board_z) {
    refuse_unsaid("a depth is below the board's surface, which is not measured",
                  "board_z_mm in [gcode], 0 if the tool is zeroed on it; or probes");
    return std::nullopt;
  }
  if (cut.depth) return *setting_.board_z - *cut.depth;
  if (!plane) {
    refuse_unsaid(fmt::format("T{} has no depth", tool_.number),
                  fmt::format("{} in [gcode] or [[gcode.tool]]", plane_key));
  }
  return plane;
}

/// Z under depth control is the lowest place of the tip (SIEB & MEYER CNC 8x.00 Command Set, Z), H
/// the height at which the tool travels.
bool GcodeWriter::keeps_to_limits(const DepthOfCut& cut, Length z) {
  constexpr Length kRounding = um(1e-3);
  if (cut.lower_limit && !setting_.table_z) {
    refuse_unsaid(
        "a lower limit of the stroke (Z# under depth control) is above the table plane, "
        "whose height is missing",
        "table_z_mm in [gcode]: 0 if the tool is zeroed on it");
    return false;
  }
  if (cut.lower_limit && z + kRounding < *setting_.table_z + *cut.lower_limit) {
    refuse(fmt::format("a depth of {:.4g} mm that ends at Z{:.4f}, below the lower limit of the "
                       "stroke ({:.4g} mm above the table)",
                       cut.depth->in_mm(),
                       z.in_mm(),
                       cut.lower_limit->in_mm()),
           "a lower Z in the program, or a higher board_z_mm in [gcode]");
    return false;
  }
  if (cut.upper_limit && setting_.table_z &&
      setting_.safe_z + kRounding < *setting_.table_z + *cut.upper_limit) {
    refuse_unsaid(fmt::format("T{} would travel at Z{:.4f}, below the travelling plane H{:.4g}",
                              tool_.number,
                              setting_.safe_z.in_mm(),
                              cut.upper_limit->in_mm()),
                  "a higher safe_z_mm in [gcode]");
    return false;
  }
  return true;
}

/// Rapid moves end above it.
bool GcodeWriter::surface_is_below(const DepthOfCut& cut) {
  if (!cut.surface || *setting_.table_z + *cut.surface < rapid_limit()) return true;
  refuse_unsaid(
      fmt::format("the board reaches up to Z{:.4f}, where T{} moves rapidly",
                  (*setting_.table_z + *cut.surface).in_mm(),
                  tool_.number),
      fmt::format("a higher {} in [gcode]", setting_.approach_z ? "approach_z_mm" : "safe_z_mm"));
  return false;
}

std::optional<Feed> GcodeWriter::infeed() {
  if (!work_.infeed) {
    refuse_unsaid(fmt::format("T{} has no infeed", tool_.number),
                  "F of the tool, or infeed_mm_s in [gcode] or [[gcode.tool]]");
  }
  return work_.infeed;
}

/// Excellon's default is known; a SIEB & MEYER control has its maker's.
std::optional<Feed> GcodeWriter::routing_feed(const Rout& rout) {
  if (!rout.feed_is_default) return rout.feed;
  if (work_.feed) return work_.feed;
  if (info().dialect == Dialect::Excellon) return rout.feed;
  refuse_unsaid(fmt::format("T{} has no feed to rout with", tool_.number),
                "F# in the program, or feed_mm_s in [gcode] or [[gcode.tool]]");
  return std::nullopt;
}

}  // namespace panelcal
