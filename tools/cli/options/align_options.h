// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "program/walk/reading_terms.h"
#include "tools/cli/options/facts_files.h"

namespace panelcal {

/// The commands of `panelcal align`.
struct AlignOptions {
  std::string pads;       ///< a list "X,Y;X,Y", or a file
  std::string alignment;  ///< verify, show: board.align.json
  std::string machine;
  std::string images;          ///< SOURCE, as of run
  std::string measurements;    ///< SOURCE
  std::string machine_driver;  ///< SOURCE
  std::string camera;          ///< SOURCE
  std::string output;
  std::string panel;                  ///< its name; may be empty
  std::string by;                     ///< name of who asks; empty: the user
  std::optional<int> vision_tool;     ///< absent: the only one, or the one of the pads' size
  std::optional<double> diameter_mm;  ///< of the fiducials of a Gerber file without attributes
  std::optional<int> n_best_holes;    ///< number of a program's holes instead of its targets
  double valid_hours = 4;             ///< show
  std::string save_measurements;
  FactsFiles facts;
  std::size_t n_threads = 0;  ///< that look at pictures; 0: one for each processor
  ReadingTerms reading;       ///< of a program of pads
};

}  // namespace panelcal
