# SPDX-License-Identifier: Apache-2.0
# panelcal_precompile(target HEADER...): the target reads its heavy headers once, not once for every
# file. A missing #include goes unseen then. So only tests, which no file includes, are always built
# that way; the rest is with PANELCAL_PRECOMPILE, beside a build without it.

option(PANELCAL_PRECOMPILE "Precompile heavy headers: builds faster, but hides missing includes" OFF)

function(panelcal_precompile target)
  get_target_property(sources ${target} SOURCES)
  list(LENGTH sources n_sources)
  set(least 5)  # making the header takes as long as reading it a few times
  if(n_sources GREATER least AND (PANELCAL_PRECOMPILE OR target MATCHES "_test$"))
    target_precompile_headers(${target} PRIVATE <algorithm> <functional> <map> <optional> <string>
                              <vector> <Eigen/Dense> ${ARGN})
  endif()
endfunction()
