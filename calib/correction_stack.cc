// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/correction_stack.h"
