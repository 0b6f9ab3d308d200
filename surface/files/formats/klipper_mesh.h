// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "surface/files/probe_file.h"
#include "surface/files/text_fields.h"
#include <Eigen/Core>

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

/// A mesh as Klipper keeps it, rows from low y: `[bed_mesh NAME]` or a profile of Moonraker's.
struct KlipperProfile {
  TextField name;
  std::map<std::string, TextField, std::less<>> values;  ///< min_x, max_x, ..., x_count, y_count
  std::vector<std::vector<TextField>> rows;
};

/// Settings of `[bed_mesh]`: places whose heights Klipper makes up, and the zero of heights.
struct KlipperBed {
  std::optional<double> radius_mm;  ///< of a round bed: rows are filled up with their end's height
  Eigen::Vector2d origin_mm = Eigen::Vector2d::Zero();
  bool may_be_round = false;  ///< the file has no settings that would say the radius
  struct Region {
    std::string name;
    std::optional<Eigen::Vector2d> low_mm, high_mm;
  };
  std::vector<Region> faulty;  ///< heights there are averages of probes about them
  std::string zero;            ///< the place of height 0; empty: the settings state none
};

/// The profile of options.profile, or the only one.
///
/// Fails  measurement-file: none, several, or not that one
Expected<const KlipperProfile*> chosen_profile(const std::vector<KlipperProfile>& profiles,
                                               const std::string& file,
                                               const ProbeFileOptions& options);

/// Fails  measurement-file: a key is missing, a count or a number is wrong, a node that Klipper
///        made up has not the height that it gives it, a mesh that may be of a round bed is filled
///        up like one
Expected<ProbeFile> file_of_profile(ProbeFormat format,
                                    const std::string& file,
                                    const KlipperProfile& profile,
                                    const KlipperBed& bed,
                                    const ProbeFileOptions& options);

}  // namespace panelcal::internal
