// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surface/files/probe_file.h"
#include "surface/files/text_fields.h"

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

/// One node of a grid as read; places and heights still in the file's unit.
struct ReadNode {
  std::optional<double> height;
  Place from;
  std::string reason = "not probed";  ///< of a node without a height
};

/// A grid as read.
struct ReadGrid {
  LatticeAxis x, y;             ///< in the file's unit
  std::vector<ReadNode> nodes;  ///< row by row
};

/// Checks a grid's size: 2 or more nodes each way, kMaxFileProbes in all.
///
/// In     at: where the file states it
/// Fails  measurement-file
Expected<void> check_grid(const std::string& file,
                          const TextField& at,
                          const LatticeAxis& x,
                          const LatticeAxis& y);

/// Points and missing nodes of a grid.
ProbeFile file_of_grid(ProbeFormat format,
                       const std::string& file,
                       const ReadGrid& grid,
                       const ProbeFileOptions& options);

}  // namespace panelcal::internal
