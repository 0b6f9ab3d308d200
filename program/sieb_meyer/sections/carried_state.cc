// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/sections/carried_state.h"

#include <cstdint>

#include "program/sieb_meyer/text/cnc_commands.h"
#include "program/sieb_meyer/text/lexer.h"

namespace panelcal::sieb_meyer {
namespace {

/// State that the next copy of a section begins with, in bits.
enum CarriedState : std::uint32_t {
  kTool = 1U,
  kPlane = 2U,         ///< Z
  kDepth = 4U,         ///< K
  kUpper = 8U,         ///< H
  kControl = 16U,      ///< G82, G83
  kDrawing = 32U,      ///< NIB, NIBO, ROUT and OPID, by which figures and texts are drawn
  kPatternMode = 64U,  ///< CAMA, NOCAMA
  kSlashes = 128U,     ///< BLKD, NOBLKD
};
constexpr std::uint32_t kOfWork = kTool | kPlane | kDepth | kUpper | kControl | kDrawing;

/// The state that M49 with this text sets.
std::uint32_t obey(std::string_view text, ReadingModes& modes) {
  const auto command = find_cnc_command(text);
  if (!command) return 0;
  switch (command->info->code) {
    case CncCode::PatternMode:
    case CncCode::HoleMode:
      modes.is_pattern_mode = command->info->code == CncCode::PatternMode;
      return kPatternMode;
    case CncCode::BlockDelete:
    case CncCode::NoBlockDelete:
      modes.deletes_blocks = command->info->code == CncCode::BlockDelete;
      return kSlashes;
    case CncCode::NibbleInOrder:
    case CncCode::NibbleAlternating:
    case CncCode::NibbleRoughness:
    case CncCode::ClearAreas:
    case CncCode::OperatorText:
      return kDrawing;
    default:
      return 0;
  }
}

/// What a line states that the next copy of its section begins with, and what it makes use of.
struct CarriedOn {
  std::uint32_t stated = 0;
  std::uint32_t used = 0;

  CarriedOn(const Block& block, ReadingModes& modes) {
    bool moves = false;
    bool measures = false;  // which needs neither tool nor depth
    for (const Word& word : block.all()) {
      const auto command =
          word.letter == 'G' || word.letter == 'M' ? command_of(word) : std::nullopt;
      if (command == Command::MeasureOffset) {
        used |= kPatternMode;
        measures |= modes.is_pattern_mode;  // else it drills
      } else {
        measures |= command && is_camera(*command);
      }
      moves |= word.letter == 'X' || word.letter == 'Y';
      if (word.letter == 'T' && parse_count(word.number).value_or(0) > 0) stated |= kTool;
      if (word.letter == 'Z') stated |= kPlane;
      if (word.letter == 'K') stated |= kDepth;
      if (word.letter == 'H') stated |= kUpper;
      if (command == Command::DepthControlOn || command == Command::DepthControlOff) {
        stated |= kControl;
      }
      if (command == Command::CncCommand) stated |= obey(block.argument, modes);
    }
    if (moves && !measures) used |= kOfWork;
  }
};

/// Of the state that is known throughout: what the next copy begins with in another way.
std::uint32_t changed(const ReadingModes& begin, const ReadingModes& end) {
  return (begin.is_pattern_mode != end.is_pattern_mode ? kPatternMode : 0U) |
         (begin.deletes_blocks != end.deletes_blocks ? kSlashes : 0U);
}

}  // namespace

bool copies_begin_alike(std::string_view bytes, const Section& section, const ReadingModes& begin) {
  ReadingModes modes = begin;
  std::uint32_t known = 0;
  std::uint32_t used = 0;  // as the copy began with it
  bool has_worked = false;
  LineCursor cursor(bytes, section.begin);
  while (cursor.offset() < section.body_end) {
    SourceLine line = cursor.next();
    if (has_worked && line.text.find_first_of("TZKHGM/") == std::string_view::npos) continue;
    if (const auto rest = without_slash(line)) {
      used |= kSlashes & ~known;
      if (modes.deletes_blocks) continue;
      line = *rest;
    }
    Block block;
    if (lex(line, block)) continue;
    const CarriedOn here(block, modes);
    if ((used & here.stated & kOfWork) != 0) return false;
    known |= here.stated;
    used |= here.used & ~known;
    has_worked |= (here.used & kOfWork) != 0;
  }
  return (used & changed(begin, modes)) == 0;
}

}  // namespace panelcal::sieb_meyer
