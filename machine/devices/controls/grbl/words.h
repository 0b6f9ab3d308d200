// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// The numbers of GRBL in words.
namespace panelcal::grbl {

/// `ALARM:1 (a limit switch was hit ...)`
///
/// In     number: as the control writes it
/// Source GRBL 1.1 interface, alarms 1 to 9; grblHAL lists the others by $EA
std::string alarm_words(std::string_view number);
/// `error:15 (...)`
///
/// Source GRBL 1.1 interface, errors 1 to 38; grblHAL lists the others by $EE
std::string error_words(std::string_view number);

/// The meaning of a state other than Idle, Run and Jog means, such as `Hold:0` or `Door:1`.
std::string state_words(std::string_view state);

}  // namespace panelcal::grbl
