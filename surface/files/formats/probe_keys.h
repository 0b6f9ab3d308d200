// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

// Not installed: shared by those who read probe readings as JSON Lines.
namespace panelcal::internal {

/// All keys of a line (docs/formats/probes.md).
inline constexpr std::array<std::string_view, 17> kProbeKeys = {"L",
                                                                "command",
                                                                "depth",
                                                                "expected",
                                                                "file",
                                                                "file_sha256",
                                                                "height",
                                                                "line",
                                                                "nominal",
                                                                "path",
                                                                "probe",
                                                                "reason",
                                                                "reference",
                                                                "sigma",
                                                                "status",
                                                                "tool",
                                                                "zaxis"};

}  // namespace panelcal::internal
