// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/front_end.h"

#include "tools/page/serve_front_end.h"

namespace panelcal::serve {

FrontEnd front_end() {
  return {kServePage, kServeScript, kServeStyle};
}

}  // namespace panelcal::serve
