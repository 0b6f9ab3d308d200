// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal {

/// Has the C library keep freed memory for the next picture, at most 62 MB, in place of giving it
/// back after each and asking for it anew: page faults were a seventh of the time of locating
/// (tests/bench/README.md).
///
/// glibc does so by itself once a process has freed a large block, and this frees one that was
/// never touched. MALLOC_TRIM_THRESHOLD_ and its kin in the environment stay in force. Source
/// mallopt(3), M_MMAP_THRESHOLD: the dynamic threshold
void keep_freed_memory();

}  // namespace panelcal
