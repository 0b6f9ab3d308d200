// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The decision of a person about a target that was not found, or that its series contradicts.
enum class Choice : std::uint8_t {
  Again,
  Search,
  Candidate,
  Hand,
  Skip,
  LeaveBoardOut,
  Keep,  ///< a target that its series contradicts: the gates hold the job
  Done,  ///< the thing that the person was asked to do
  Stop,
};
std::string_view name(Choice choice);
std::optional<Choice> choice_from_name(std::string_view name);

/// The answer to a question, and who gave it.
struct Answer {
  int question = 0;
  Choice choice = Choice::Again;
  std::optional<Eigen::Vector2d> at_px;  ///< Search, Hand: of the picture shown
  std::optional<std::size_t> index;      ///< Candidate
  std::optional<std::uint64_t> frame;    ///< Search, Hand: the number of that picture
  std::optional<double> lamp;            ///< Again
  std::optional<double> exposure_us;     ///< Again
  std::string who;
};

enum class Order : std::uint8_t {
  Open,
  Close,
  Start,
  Resume,
  Stop,
  Answer,
  Jog,
  Write,
  Calibrate,
  RollBack,
};

/// One order of the person who holds the controls. Only the members of its order are set.
struct Command {
  Order order = Order::Stop;
  std::string name;  ///< Open: the program; Write: the output; Calibrate, RollBack: the kind
  Answer answer;
  Eigen::Vector2d by_mm = Eigen::Vector2d::Zero();  ///< Jog
  std::int64_t to = 0;                              ///< RollBack: the ledger's entry
  std::string reason;                               ///< RollBack
  std::string who;
};

/// Reads {"do": ...} as the operator's screen writes it.
///
/// Fails  json-syntax; usage (an unknown word or key, a key that is missing or of another type)
/// See    tests/machine/operator/command_test.cc
Expected<Command> parse_command(std::string_view json, const std::string& who);

/// The answer to a command that is refused.
Diagnostic refused(std::string what, std::string expected);

}  // namespace panelcal::internal
