// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

namespace panelcal {

/// The rights of any new file of the user, for one that is made with fewer: 0666 less what umask(2)
/// takes away.
///
/// umask() tells its value only by setting another one. Two threads that do so at once may leave
/// the process with none, and every later file open to everyone; the kernel is asked instead
/// (proc(5), Umask). Where /proc is not mounted, only the owner gets rights.
mode_t usual_file_rights();

}  // namespace panelcal
