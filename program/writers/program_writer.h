// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "program/walk/reporter.h"
#include "program/writers/output_digits.h"
#include "program/writers/text_writer.h"
#include <Eigen/Core>

namespace panelcal {

struct ProgramWriterOptions {
  /// The file's maker and inputs: one line each.
  std::vector<std::string> comments;
  /// Leaves out what decides where or how deep a tool goes and has no form in the language, instead
  /// of failing. Code that sets it has to look at losses().
  bool allow_losses = false;
  /// The operations were passed with WalkOptions::structure Kept: the vision system's settings are
  /// the control's again.
  bool keeps_vision = false;
  int default_vision_tool = 1;  ///< of a SIEB & MEYER source without G35
  /// Of coordinates; absent: the control's grid (output_digits.h).
  std::optional<Length> resolution = std::nullopt;
  /// Those of WalkOptions: each language counts a program's zero from another one.
  Position<frame::Machine> absolute_zero;
  Position<frame::Machine> work_zero;
};

/// Base of writers of programs: the axes they write in, and an account of all that the language
/// has no form for.
class ProgramWriter : public TextWriter {
 public:
  void begin(const ProgramInfo& info) override;

  /// translation-loss and translation-refused, each once, in the order of the operations.
  const DiagnosticLog& losses() const { return losses_; }

 protected:
  /// In     dialect: that is written; empty: G-code, which no part program comes in
  ProgramWriter(ByteSink& bytes, std::optional<Dialect> dialect, ProgramWriterOptions options);

  const ProgramWriterOptions& options() const { return options_; }
  const ProgramInfo& info() const { return info_; }
  /// Of lengths, from begin() on. In G-code, whose numbers have any, they are not used.
  const OutputDigits& digits() const { return digits_; }
  /// A number that has more digits than the control reads: the output fails, whatever is allowed.
  void check_digits(std::string_view number) {
    // A point, and no sign: nearly all numbers are that short.
    if (number.size() > static_cast<std::size_t>(digits_.n_digits) + 1) count_digits(number);
  }
  void count_digits(std::string_view number);
  /// Settings and functions are texts of the other language.
  bool is_foreign() const { return info_.dialect != dialect_; }
  /// Call first for each operation: losses name its line.
  void note_place(const Operation& operation);
  Place place() const;
  int source_line() const { return line_; }
  void line(std::string_view block) {
    text() += block;
    text() += '\n';
  }
  /// Valid during put().
  std::string_view source_file() const { return file_; }

  /// `what`, a noun, has no form and is left out; it changes neither places nor depths.
  void lose(std::string what);
  /// The same for what the program says again and again.
  void lose_once(const std::string& what);
  /// `what` has no form, and without it a tool would go elsewhere or to another depth. The output
  /// fails unless losses are allowed.
  void refuse(std::string what, std::string expected = "");
  /// A value that a tool needs is missing: `problem`, a sentence. Fails as refuse() does; each
  /// problem once.
  void refuse_unsaid(const std::string& problem, std::string expected);

  /// A setting of the vision system in a program without vision commands. Most were executed; those
  /// that no walk obeys are lost, and so are calibrations and focusing that were not performed.
  void lose_vision(const Setting& setting);

  /// Magazines and dwells of tools, which a SIEB & MEYER source states in its tool table.
  void lose_tool_table();

  /// One plane does for all Z axes; refuses where their surfaces differ by more than some um.
  bool serves_all_axes(const DepthOfCut& cut);

  /// A message of the operator's without what a SIEB & MEYER control takes for an order of its own.
  std::string_view words_of(std::string_view message);

  /// Goes on in this axis version; begin() takes the program's.
  void write_in_axes(int version);
  /// Into the axis version that is written.
  const Eigen::Matrix2d& written_from_work() const { return written_from_work_; }
  /// That map is a mirror: clockwise and left are the other way round.
  bool is_mirrored() const { return is_mirrored_; }

 private:
  std::string without_form(std::string what) const;
  void refuse_as(std::string problem, std::string expected);

  std::optional<Dialect> dialect_;
  ProgramWriterOptions options_;
  ProgramInfo info_;
  OutputDigits digits_;
  Eigen::Matrix2d written_from_work_ = Eigen::Matrix2d::Identity();
  bool is_mirrored_ = false;
  DiagnosticLog losses_;
  std::optional<Reporter> reporter_;
  std::set<std::string> said_;
  int line_ = 0;
  std::string_view file_;  ///< valid during put()
};

/// Printable ASCII; anything else, such as a line end that would become a command, is a '?'.
std::string printable(std::string_view text);

}  // namespace panelcal
