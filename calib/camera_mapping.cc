// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/camera_mapping.h"
