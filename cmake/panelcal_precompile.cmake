# SPDX-License-Identifier: Apache-2.0
# panelcal_precompile(target HEADER...): with PANELCAL_PRECOMPILE the target reads its heavy headers
# once, not once for every file. A missing #include goes unseen then, so that a build without it
# has to be made as well.

option(PANELCAL_PRECOMPILE "Precompile heavy headers: builds faster, but hides missing includes" OFF)

function(panelcal_precompile target)
  if(PANELCAL_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE <algorithm> <functional> <map> <optional> <string>
                              <vector> <Eigen/Dense> ${ARGN})
  endif()
endfunction()
