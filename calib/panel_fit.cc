// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/panel_fit.h"
