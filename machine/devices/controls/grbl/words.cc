// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/grbl/words.h"

#include <span>
#include <utility>

#include <fmt/format.h>

namespace panelcal::grbl {
namespace {

using Word = std::pair<std::string_view, std::string_view>;

constexpr Word kAlarms[] = {
    {"1", "a limit switch was hit: the position is lost, home the machine"},
    {"2", "the move leaves the travel: it was not made"},
    {"3", "a reset in motion: the position is lost, home the machine"},
    {"4", "the probe was tripped before it moved"},
    {"5", "the probe touched nothing on its way"},
    {"6", "homing was reset"},
    {"7", "the safety door was opened while homing"},
    {"8", "a limit switch stayed pressed after homing"},
    {"9", "homing found no limit switch"},
    {"10", "the emergency stop is pressed"},
    {"11", "the machine has to be homed"},
    {"12", "a limit switch is pressed"},
    {"13", "the probe touched something outside a probing move"},
    {"14", "the spindle did not reach its speed"},
    {"15", "homing found no second limit switch"},
    {"16", "the control's self-test failed"},
    {"17", "a motor has a fault"},
    {"18", "the settings of homing do not fit"},
};

constexpr Word kErrors[] = {
    {"1", "a word without its letter"},
    {"2", "a word without its number"},
    {"3", "the control does not know this $ command"},
    {"4", "a negative value"},
    {"5", "homing is switched off"},
    {"7", "the stored settings could not be read"},
    {"8", "the control is not idle"},
    {"9", "locked by an alarm or a jog"},
    {"10", "soft limits need homing"},
    {"11", "the line is too long"},
    {"13", "the safety door is open"},
    {"15", "the place is outside the travel: nothing moved"},
    {"16", "a jog with words that are no jog's"},
    {"18", "the control is being reset"},
    {"20", "the control does not know this G or M word"},
    {"21", "two words of one group"},
    {"22", "no feed"},
    {"24", "two words that need axes"},
    {"26", "no axis"},
    {"30", "G53 without G0 or G1"},
    {"31", "axes without a move"},
    {"33", "the target is not valid"},
    {"45", "a limit switch is pressed: only homing is allowed"},
    {"46", "the machine has to be homed"},
    {"50", "the emergency stop is pressed"},
    {"51", "a motor has a fault"},
    {"77", "the control asks for a password"},
    {"79", "locked by an alarm until it is reset"},
};

constexpr Word kControlStates[] = {
    {"Alarm", "locked by an alarm"},
    {"Hold", "in feed hold"},
    {"Door", "stopped by its safety door"},
    {"Check", "in check mode, in which nothing moves"},
    {"Home", "homing"},
    {"Sleep", "asleep, its motors off"},
    {"Tool", "waiting for a change of tool"},
    {"Run", "in motion by another's order"},
    {"Jog", "in motion by another's jog"},
};

std::string_view found(std::span<const Word> words, std::string_view key) {
  for (const auto& [number, meaning] : words) {
    if (number == key) return meaning;
  }
  return "";
}

std::string numbered(std::string_view kind, std::string_view number, std::span<const Word> words) {
  const std::string_view meaning = found(words, number);
  const std::string name = fmt::format("{}:{}", kind, number);
  return meaning.empty() ? name : fmt::format("{} ({})", name, meaning);
}

}  // namespace

std::string alarm_words(std::string_view number) {
  return numbered("ALARM", number, kAlarms);
}

std::string error_words(std::string_view number) {
  return numbered("error", number, kErrors);
}

std::string state_words(std::string_view state) {
  const auto colon = state.find(':');
  const std::string_view name = state.substr(0, colon);
  const std::string_view meaning = found(kControlStates, name);
  if (meaning.empty()) return fmt::format("in the unknown state {}", state);
  if (name == "Alarm" && colon != state.npos) {
    const std::string_view why = found(kAlarms, state.substr(colon + 1));
    if (!why.empty()) return fmt::format("locked by an alarm, {}: {}", state, why);
  }
  return fmt::format("{} ({})", meaning, state);
}

}  // namespace panelcal::grbl
