// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "program/gcode/block.h"
#include "program/gcode/motion.h"

namespace panelcal::gcode {

/// Writes lines of G-code in the place of one that was read: with its other words and its comments,
/// but other coordinates.
///
/// Ends of moves keep the digits that the program has, lest a full circle become none, or the other
/// way round; the new line has enough that this does not happen. Lines end with LF.
class GcodeLines {
 public:
  /// In     n_decimals: of X, Y, I and J in millimetres; inches get one more, up to 7. A ten-
  ///        thousandth of a micrometre is more than any program has
  explicit GcodeLines(int n_decimals = 7) : n_decimals_(n_decimals) {}

  /// The line as it is; if LinuxCNC would refuse it as too long, in several.
  void put(const GcodeBlock& block);

  /// A line of modal words that the program relies on and does not state; nothing if there are
  /// none.
  void put_unstated(std::string_view words);

  /// A line of its own that leads straight to a height, rapidly. It states its modes, which may be
  /// those of the block that follows.
  void put_rise(double z_mm, const Counting& counting);

  /// The words of a block that belong before its move; then the coordinates; then end_line() or,
  /// for the block's last move, end_block().
  ///
  /// In     kind: stands in the place of the block's G0 to G3, or is added if it has none
  void begin_block(const GcodeBlock& block, std::optional<MotionKind> kind = std::nullopt);
  /// A further move of the same kind.
  void begin_move(MotionKind kind);
  /// X, Y, Z or R. Steps (G91) lead from where what was written so far has led, so that rounding
  /// does not add up.
  void put_place(char letter, double value_mm, const Counting& counting);
  /// The place where the tool stands already, to the last digit: the end of a full circle.
  void put_standing(const Counting& counting);
  void put_height(char letter, double value_mm, const Counting& counting);
  /// I or J.
  void put_offset(char letter, double value_mm, const Counting& counting);
  /// A word of the block as it is, if it has it. Where it leads is left to stand_at().
  void put_word(const GcodeBlock& block, char letter);
  void end_line();
  /// Also writes comments, and the words that come after a move: stops and ends.
  void end_block(const GcodeBlock& block);

  /// Of lines that are put as they are, and of cycles: where the tool is then.
  void stand_at(const Standing& at) { told_ = at; }
  /// The place to which the written lines lead, by the control.
  const Standing& standing() const { return told_; }
  /// The same of a line of steps.
  void step(const Motion& motion);

  std::string take() { return std::move(text_); }
  const std::string& text() const { return text_; }

 private:
  void put_long(const GcodeBlock& block);
  void put_comments(const GcodeBlock& block);
  void put_coordinate(char letter, double value_mm, const Counting& counting, int n_decimals);
  double put_number(char letter, double value, int n_decimals);
  void put_others(const GcodeBlock& block, bool after, std::optional<MotionKind> kind);
  void put_text(std::string_view word);
  int decimals(const Counting& counting) const;

  int n_decimals_;
  Standing told_;     ///< the tool's place by the control
  std::string line_;  ///< that is being written
  std::string text_;
};

}  // namespace panelcal::gcode
