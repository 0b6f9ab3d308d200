// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "program/excellon/text/stated_format.h"
#include "program/model/command_class.h"
#include "program/text/number_format.h"
#include "program/text/source_text.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal::excellon {

/// The treatment of a header command: changes how the program is read, is given to the machine in
/// order, or would move coordinates in a way that no manual states.
enum class HeaderWordKind : std::uint8_t { Handled, Passed, Refused };

/// A header word for documents: `kind` is handled, passed or refused.
struct HeaderWordInfo {
  std::string_view word;
  CommandClass command_class;
  std::string_view effect;
  std::string_view kind;
};
std::vector<HeaderWordInfo> header_word_table();

/// Absent: no word of the manual's table.
std::optional<HeaderWordKind> kind_of_header_word(std::string_view word);
/// The word that is meant, empty if none is near enough.
std::string_view nearest_header_word(std::string_view word);

/// A header command: its word, and what follows the first comma.
struct HeaderCommand {
  std::string_view word;
  std::string_view value;

  std::string text() const;
};
HeaderCommand split_header_command(std::string_view block);

/// The words of INCH and METRIC behind their comma.
struct FormatWords {
  std::optional<Zeros> zeros;
  std::optional<std::pair<int, int>> digits;  ///< before and behind the point
};
/// Absent: another word than LZ, TZ and digits.
std::optional<FormatWords> read_format_words(std::string_view value);

/// The statement of INCH or METRIC, its source left open. Absent: it is another word, or has others
/// than LZ, TZ and digits behind its comma.
std::optional<PartialFormat> unit_statement(const HeaderCommand& command);

/// An option that comes again means the same whatever its spelling, states more, or contradicts.
enum class OptionAgain : std::uint8_t { Same, More, Contradicts };
/// Compares values, not spellings: `ICI` is `ICI,ON`, and `METRIC,TZ` repeats `METRIC,000.000,TZ`.
/// Parts of a format that the operator rules over contradict nothing.
///
/// In     stated: in force
/// Precondition: the words are the same
OptionAgain compare_options(const HeaderCommand& first,
                            const HeaderCommand& again,
                            const StatedFormat& stated);

/// True for a header command that stands outside the header: a known word that a comma follows, or
/// one of more than one letter alone. CAN_TEXT_OFF does not count: it is a command of the body.
bool is_header_word(std::string_view block);

/// Modes of the body that CAM systems write among header commands: G90, G91, M71, M72.
bool is_set_up(std::string_view text);

/// The next thing behind set-up words (G90, G91, M71, M72), comments and empty lines.
enum class HeaderAhead : std::uint8_t {
  Start,  ///< M48
  Word,   ///< a header command outside the header
  None,   ///< the body
};
/// In     may_rewind: a % counts as an empty line once: before the first block it is a rewind stop,
///        which some CAM systems also put before M48
HeaderAhead look_ahead(LineCursor cursor, bool may_rewind);

/// Digits as INCH and METRIC state them: `000.000`.
bool is_digit_mask(std::string_view text);

/// Reads `#` or `#,#` of CAN_TEXT_OFF into `offset_mm`; what is left out stays.
///
/// Fails  with what was expected
tl::expected<void, std::string> read_text_offset(std::string_view value,
                                                 const NumberFormat& format,
                                                 Eigen::Vector2d& offset_mm);

}  // namespace panelcal::excellon
