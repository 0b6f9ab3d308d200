// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "calib/base/expected.h"

// Not installed: where `panelcal synth` puts its pictures.
namespace panelcal::internal {

/// Makes a folder ready for pictures of the virtual camera.
///
/// Removes an earlier synth's files: its truth.json, images.csv, and the pictures that either
/// of them lists, so that no old picture is taken for a new one. Everything else stays. Where it
/// might be mixed up with what is to come, nothing is touched and the folder is refused.
///
/// In     folder: made if it does not exist
/// Fails  usage (a list or a numbered picture that no synth made, or one that was interrupted);
///        device-write
/// See    tests/machine/sim/pictures/synth_folder_test.cc
Expected<void> prepare_synth_folder(const std::filesystem::path& folder);

}  // namespace panelcal::internal
