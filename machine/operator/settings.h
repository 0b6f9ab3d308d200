// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "calib/base/clock.h"

namespace panelcal {

struct NightRecord;

/// Larger programs are refused.
inline constexpr std::size_t kMaxProgramBytes = std::size_t{64} << 20;
/// Larger commands are refused.
inline constexpr std::size_t kMaxCommandBytes = std::size_t{64} << 10;

/// The machine that people operate from a screen, and what it works with.
struct StationSettings {
  std::filesystem::path machine_file;  ///< read again at each start of a job
  std::filesystem::path jobs_folder;   ///< programs/ beneath it; one folder a job
  // Exactly one of the three:
  std::string camera;          ///< an address, or empty
  std::string images;          ///< a folder of pictures, or empty
  std::string machine_driver;  ///< "sim", or empty
  /// Makes the page of a document of facts, as page_html() of tools/page; empty: jobs have no page.
  std::function<std::string(std::string_view title,
                            std::string_view facts,
                            const std::map<std::string, std::string>& pictures)>
      page = {};
  /// Makes the page of a night; empty: calibrations have no page.
  std::function<std::string(const NightRecord&)> night_page = {};
  Clock clock = {};           ///< empty: the computer's
  std::string software = {};  ///< "panelcal 0.1.0", for the ledger and the outputs
};

}  // namespace panelcal
