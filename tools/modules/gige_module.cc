// SPDX-License-Identifier: Apache-2.0
#include "tools/modules/gige_functions.h"
#include "tools/modules/module.h"

namespace {

constexpr panelcal::modules::GigeFunctions kGigeFunctions = {
    .open_gige_camera = &panelcal::open_gige_camera,
};

}  // namespace

extern "C" [[gnu::visibility("default")]] const PanelcalModule panelcal_module = {
    PANELCAL_VERSION, &kGigeFunctions, nullptr};
