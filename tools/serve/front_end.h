// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/serve/service.h"

namespace panelcal::serve {

/// The pages of web/serve, as the program has them.
FrontEnd front_end();

}  // namespace panelcal::serve
