# SPDX-License-Identifier: Apache-2.0
# panelcal_precompile(target): with PANELCAL_PRECOMPILE the target reads its heavy headers once, not
# once for every file. A missing #include goes unseen then, so there must be a build without it. Tests,
# which no file includes, are always built that way.

option(PANELCAL_PRECOMPILE "Precompile heavy headers: builds faster, but hides missing includes" OFF)

function(panelcal_precompile target)
  get_target_property(sources ${target} SOURCES)
  list(LENGTH sources n_sources)
  set(least 5)  # making the header takes as long as reading it a few times
  if(PANELCAL_PRECOMPILE AND n_sources GREATER least)
    target_precompile_headers(${target} PRIVATE <algorithm> <functional> <map> <optional> <string>
                              <vector> <Eigen/Dense>)
  endif()
endfunction()
