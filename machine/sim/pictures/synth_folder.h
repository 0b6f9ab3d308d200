// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"

// Not installed: where `panelcal synth` puts its pictures.
namespace panelcal::internal {

/// The list of what synth wrote into a folder, as `sha256sum -c` reads it.
inline constexpr std::string_view kSynthManifest = "synth.sha256";

/// Makes a folder ready for pictures of the virtual camera.
///
/// Removes what an earlier synth's manifest lists, so that no old picture is taken for a new one;
/// everything else stays. A list or a numbered picture that is not there as synth wrote it, byte
/// for byte, is another's: nothing is touched and the folder is refused.
///
/// In     folder: made if it does not exist
/// Fails  usage (a list or a numbered picture that no synth wrote, that was replaced since, or that
///        an interrupted one wrote); device-write
/// See    tests/machine/sim/pictures/synth_folder_test.cc
Expected<void> prepare_synth_folder(const std::filesystem::path& folder);

/// Writes the manifest of the files that synth has written: the folder is finished.
///
/// In     names: within the folder
/// Fails  file-unreadable; device-write
Expected<void> finish_synth_folder(const std::filesystem::path& folder,
                                   std::vector<std::string> names);

}  // namespace panelcal::internal
