// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/mover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "calib/base/plane_vectors.h"
#include "program/gcode/block.h"
#include "program/gcode/executed_lines.h"
#include "program/gcode/lines.h"
#include "program/gcode/motion.h"
#include "program/geometry/bent_path.h"
#include "program/writers/rounded_arc.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Vector2d;
using gcode::Counting;
using gcode::ExecutedLine;
using gcode::GcodeBlock;
using gcode::GcodeLines;
using gcode::GcodeWord;
using gcode::Motion;
using gcode::MotionKind;
using gcode::MotionReader;
using gcode::Standing;

/// Ten nanometres; in inches a fortieth of a micrometre.
constexpr int kDecimals = 5;
/// Rounded ends of a shorter arc may be one place, which is a full circle to the control.
constexpr double kLeastChord_mm = 1e-4;
constexpr double kArcStep_mm = 2;
constexpr int kLeastArcSamples = 24;
constexpr int kMostArcSamples = 8192;
constexpr std::array kShifts = {52.0, 92.0, 92.1, 92.2};

/// A line or an arc of the written program.
struct Piece {
  double share = 1;  ///< of the program's move up to its end
  Vector2d end_mm = Vector2d::Zero();
  MotionKind kind = MotionKind::Line;
  Vector2d center_mm = Vector2d::Zero();  ///< of an arc
};

/// Precondition: an arc.
bool is_full_circle(const Motion& motion) {
  return motion.is_arc() && motion.from.xy_mm() == motion.to.xy_mm();
}

class Mover {
 public:
  Mover(const SourceText& program, const BoardPlaces& places, const MoveOptions& options)
      : program_(program),
        places_(places),
        options_(options),
        reader_(program.file, options.unit_mm) {}

  Expected<MovedGcode> move() {
    if (!(options_.tolerance > Length())) {
      return failure({Code::ArgumentInvalid,
                      {program_.file, 0, 0},
                      "a tolerance of 0 or less",
                      "one above 0"});
    }
    gcode::ExecutedLines lines(program_);
    while (true) {
      PANELCAL_TRY(const std::optional<ExecutedLine> next, lines.next());
      if (!next) break;
      PANELCAL_CHECK(put(*next));
      note_lines(next->line.number);
      tell_progress(next->line);
    }
    return MovedGcode{lines_.take(), std::move(source_lines_), figures_};
  }

 private:
  tl::unexpected<Diagnostic> problem(const GcodeBlock& block,
                                     const GcodeWord* word,
                                     Code code,
                                     std::string what,
                                     std::string expected) const {
    const int column = word == nullptr ? 1 : static_cast<int>(word->begin) + 1;
    return failure(
        {code, {program_.file, block.line, column}, std::move(what), std::move(expected)});
  }

  static std::string text_of(const GcodeBlock& block, const GcodeWord& word) {
    return quoted(block.text.substr(word.begin, word.end - word.begin));
  }

  void note_lines(int source_line) {
    const std::string& text = lines_.text();
    const auto n_new =
        std::count(text.begin() + static_cast<std::ptrdiff_t>(n_noted_), text.end(), '\n');
    source_lines_.insert(source_lines_.end(), static_cast<std::size_t>(n_new), source_line);
    n_noted_ = text.size();
  }

  // --- lines -----------------------------------------------------------------------------------

  Expected<void> put(const ExecutedLine& next) {
    if (next.is_order) {
      put_order(next.line);
      return {};
    }
    PANELCAL_TRY(const GcodeBlock block, gcode::read_gcode_block(next.line, program_.file));
    for (const GcodeWord& word : block.words) {
      if (next.is_inside && word.is_computed) {
        return problem(block,
                       &word,
                       Code::NotSupported,
                       text_of(block, word) + " in a subprogram, whose variables are its own",
                       "a number as it is");
      }
      if (word.letter == 'G' && std::ranges::find(kShifts, word.value) != kShifts.end()) {
        return put_shift(block, word);
      }
    }
    PANELCAL_TRY(const auto motion, reader_.read(block));
    lines_.put_unstated(reader_.take_unstated(block, motion));
    if (!motion) {
      figures_.n_left += reader_.has_left() ? 1 : 0;
      lines_.put(block);
    } else {
      ++figures_.n_moves;
      PANELCAL_CHECK(put_motion(block, *motion));
      PANELCAL_CHECK(note_places(block, *motion));
    }
    // Behind a change of tool or a way home.
    if (!reader_.standing().has_xy()) lines_.stand_at({{}, {}, lines_.standing().z_mm});
    for (const GcodeWord& word : block.words) {
      const bool is_line = word.is('G', 0) || word.is('G', 1);
      const bool is_arc = word.is('G', 2) || word.is('G', 3);
      // Where no arc is written, an arc's word is in force as the program has it.
      if (is_line || (is_arc && !(motion && motion->is_arc()))) in_force_.reset();
    }
    return {};
  }

  /// What a subprogram's order did stands there; the order itself becomes a comment.
  void put_order(const SourceLine& line) {
    std::string words(line.text);
    std::ranges::replace(words, '(', '[');
    std::ranges::replace(words, ')', ']');
    remark_ = fmt::format("(written out: {})", words);
    GcodeBlock block;
    block.text = remark_;
    block.rest = remark_;
    lines_.put(block);
  }

  // --- zeros -----------------------------------------------------------------------------------

  /// G92, G52 and their cancels: the zero of coordinates moves, and the written program's likewise.
  Expected<void> put_shift(const GcodeBlock& block, const GcodeWord& code) {
    for (const GcodeWord& word : block.words) {
      const bool is_axis = word.letter == 'X' || word.letter == 'Y' || word.letter == 'Z';
      if (block.is_deleted || word.is_computed ||
          (!is_axis && word.letter != 'N' && &word != &code)) {
        return problem(block,
                       &word,
                       Code::NotSupported,
                       text_of(block, word) + " beside " + text_of(block, code),
                       "a line of its own, with numbers as they are");
      }
    }
    if (!reader_.has_unit()) {
      return problem(block,
                     &code,
                     Code::ArgumentInvalid,
                     text_of(block, code) + " before its unit is known",
                     "G20 (inches) or G21 (millimetres) before it");
    }
    Standing nominal = reader_.standing(), written = lines_.standing();
    PANELCAL_CHECK(shift_axis(block, code, 'X', nominal.x_mm, written.x_mm));
    PANELCAL_CHECK(shift_axis(block, code, 'Y', nominal.y_mm, written.y_mm));
    PANELCAL_CHECK(shift_axis(block, code, 'Z', nominal.z_mm, written.z_mm));
    reader_.stand_at(nominal);
    lines_.stand_at(written);
    lines_.put_unstated(reader_.take_unstated(block, Motion()));
    lines_.put(block);
    return {};
  }

  /// Takes the places of one axis to the new zero: as the program has it, and as it is written.
  ///
  /// Source LinuxCNC, G92 and G52: both set the same offset
  Expected<void> shift_axis(const GcodeBlock& block,
                            const GcodeWord& code,
                            char letter,
                            std::optional<double>& nominal_mm,
                            std::optional<double>& written_mm) {
    const GcodeWord* const word = block.find(letter);
    const bool is_cancel = code.value > 92;
    if (word == nullptr && !is_cancel) return {};
    const double value_mm = word == nullptr ? 0 : word->value * reader_.counting().unit_mm;
    const int axis = letter - 'X';
    const auto move_zero = [&](std::optional<double>& at_mm, double& zero_mm) {
      const double old_mm =
          std::exchange(zero_mm,
                        is_cancel          ? 0
                        : code.value == 92 ? zero_mm + at_mm.value_or(0) - value_mm
                                           : value_mm);
      if (at_mm) *at_mm += old_mm - zero_mm;
    };
    // Z is written as the program has it.
    const bool is_known = nominal_mm && (letter == 'Z' || written_mm);
    if (code.value == 92 && !is_known) {
      return problem(block,
                     word,
                     Code::CoordinateMissing,
                     text_of(block, *word) + " where the tool's place is unknown",
                     "a move to X, Y and Z before it");
    }
    move_zero(nominal_mm, zero_mm_[axis]);
    move_zero(written_mm, written_zero_mm_[axis]);
    return {};
  }

  /// A place of the board, from one of the program and the other way round for a written one.
  Vector2d on_board(const Vector2d& program_mm) const { return program_mm + zero_mm_.head<2>(); }
  Vector2d image_of(const Vector2d& program_mm) const {
    return places_.actual_mm(on_board(program_mm));
  }

  // --- moves -----------------------------------------------------------------------------------

  Expected<void> put_motion(const GcodeBlock& block, const Motion& motion) {
    if (!block.has('X') && !block.has('Y') && !motion.is_arc()) {
      lines_.put(block);
      follow_height(motion);
      return {};
    }
    const bool is_step = reader_.counting().is_incremental;
    if (!motion.to.has_xy() || (is_step && !motion.from.has_xy())) {
      return problem(
          block,
          nullptr,
          Code::CoordinateMissing,
          is_step ? "a step from an unknown place" : "X or Y alone, the other is unknown",
          "a move to X and Y in G90 before it");
    }
    ++figures_.n_moved;
    const bool is_way = motion.from.has_xy() && motion.kind != MotionKind::Rapid &&
                        motion.kind != MotionKind::Cycle;
    const std::vector<Piece> pieces =
        !is_way ? std::vector{Piece{.end_mm = image_of(motion.to.xy_mm()), .kind = motion.kind}}
        : motion.is_arc() ? arc_pieces(motion)
                          : line_pieces(motion);
    figures_.n_pieces += static_cast<std::int64_t>(pieces.size());
    return put_pieces(block, motion, pieces);
  }

  std::vector<Piece> line_pieces(const Motion& motion) const {
    const Arc line{.start_mm = motion.from.xy_mm(), .end_mm = motion.to.xy_mm(), .straight = true};
    std::vector<Piece> pieces;
    for (const BentPiece& bent : carry_bent(
             line, [this](const Vector2d& p) { return image_of(p); }, options_.tolerance.in_mm())) {
      pieces.push_back({.share = bent.share, .end_mm = bent.image.end_mm});
    }
    return pieces;
  }

  std::vector<Piece> arc_pieces(const Motion& motion) const {
    if (const auto whole = whole_arc(motion)) return {*whole};
    const int n_parts =
        static_cast<int>(std::ceil(std::abs(motion.sweep_rad) / std::numbers::pi - 1e-9));
    std::vector<Piece> pieces;
    for (int i = 0; i < n_parts; ++i) append_part(motion, i, n_parts, pieces);
    pieces.back().end_mm = image_of(motion.to.xy_mm());
    return pieces;
  }

  /// The image of an arc as one arc, if it is within the tolerance.
  std::optional<Piece> whole_arc(const Motion& motion) const {
    const double length_mm = gcode::length_mm(motion);
    const int n =
        std::max(kLeastArcSamples,
                 static_cast<int>(std::min(1.0 * kMostArcSamples, length_mm / kArcStep_mm)));
    const Vector2d from_mm = image_of(motion.from.xy_mm()), to_mm = image_of(motion.to.xy_mm());
    if (!is_full_circle(motion) && !((to_mm - from_mm).norm() > kLeastChord_mm))
      return std::nullopt;
    const Vector2d center_mm = center_of_rounded(from_mm, to_mm, image_of(motion.center_mm));
    const double radius_mm = (from_mm - center_mm).norm();
    if (!(radius_mm > kLeastChord_mm)) return std::nullopt;
    Vector2d last_mm = from_mm;
    double turn = 0;
    for (int i = 1; i <= n; ++i) {
      const Vector2d p_mm = image_of(gcode::place_mm(motion, static_cast<double>(i) / n));
      if (!(std::abs((p_mm - center_mm).norm() - radius_mm) <= options_.tolerance.in_mm())) {
        return std::nullopt;
      }
      turn += internal::cross(last_mm - center_mm, p_mm - center_mm);
      last_mm = p_mm;
    }
    return Piece{.end_mm = to_mm,
                 .kind = turn < 0 ? MotionKind::Clockwise : MotionKind::Counterclockwise,
                 .center_mm = center_mm};
  }

  /// One of equal parts of an arc, none above half a turn, as arcs and lines.
  void append_part(const Motion& motion, int i, int n_parts, std::vector<Piece>& pieces) const {
    const double begin = static_cast<double>(i) / n_parts;
    const double end = static_cast<double>(i + 1) / n_parts;
    const Vector2d start = motion.from.xy_mm() - motion.center_mm;
    const auto on_circle = [&](double share) {
      const double turn_rad = share * motion.sweep_rad;
      const double c = std::cos(turn_rad), s = std::sin(turn_rad);
      return Vector2d(c * start.x() - s * start.y(), s * start.x() + c * start.y());
    };
    const Vector2d middle = on_circle(0.5 * (begin + end));
    // The radii at the ends of the program's arc may differ by what the control forgives: the map
    // takes a circle to that path first.
    const auto map = [&](const Vector2d& p_mm) {
      const Vector2d p = p_mm - motion.center_mm;
      const double turn_rad = std::atan2(internal::cross(middle, p), middle.dot(p));
      const double part = 0.5 * (begin + end) + turn_rad / motion.sweep_rad;
      return image_of(gcode::place_mm(motion, std::clamp(part, begin, end)));
    };
    const Arc path{.start_mm = motion.center_mm + on_circle(begin),
                   .end_mm = motion.center_mm + on_circle(end),
                   .center_mm = motion.center_mm,
                   .clockwise = motion.kind == MotionKind::Clockwise};
    for (const BentPiece& bent : carry_bent(path, map, options_.tolerance.in_mm())) {
      const Arc& image = bent.image;
      const bool is_line =
          image.straight || !((image.end_mm - image.start_mm).norm() > kLeastChord_mm);
      pieces.push_back({.share = begin + bent.share * (end - begin),
                        .end_mm = image.end_mm,
                        .kind = is_line           ? MotionKind::Line
                                : image.clockwise ? MotionKind::Clockwise
                                                  : MotionKind::Counterclockwise,
                        .center_mm = image.center_mm});
    }
  }

  // --- what is written -------------------------------------------------------------------------

  Expected<void> put_pieces(const GcodeBlock& block,
                            const Motion& motion,
                            const std::vector<Piece>& pieces) {
    const bool is_whole = pieces.size() == 1;
    if (!is_whole && block.has('Z') && !motion.from.z_mm) {
      return problem(block,
                     block.find('Z'),
                     Code::CoordinateMissing,
                     "a move from an unknown height that has to be cut",
                     "Z before it");
    }
    Vector2d from_mm =
        motion.from.has_xy() ? image_of(motion.from.xy_mm()) : Vector2d(Vector2d::Zero());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const Piece& piece = pieces[i];
      i == 0 ? begin_block(block, motion, piece.kind) : lines_.begin_move(piece.kind);
      put_end(block, motion, piece, is_whole);
      if (piece.kind == MotionKind::Clockwise || piece.kind == MotionKind::Counterclockwise) {
        put_center(piece, from_mm);
      }
      from_mm = piece.end_mm;
      i + 1 < pieces.size() ? lines_.end_line() : lines_.end_block(block);
    }
    if (motion.is_arc()) in_force_ = pieces.back().kind;
    if (is_whole) follow_height(motion);
    return {};
  }

  /// States the kind of a move where the program does, and where another is in force.
  void begin_block(const GcodeBlock& block, const Motion& motion, MotionKind kind) {
    if (!motion.is_arc()) return lines_.begin_block(block);
    const bool is_stated = std::ranges::any_of(
        block.words, [](const GcodeWord& word) { return word.is('G', 2) || word.is('G', 3); });
    const bool is_needed = is_stated || in_force_.value_or(motion.kind) != kind;
    lines_.begin_block(block, is_needed ? std::optional(kind) : std::nullopt);
  }

  void put_end(const GcodeBlock& block, const Motion& motion, const Piece& piece, bool is_whole) {
    const Counting counting = reader_.counting();
    if (is_whole && is_full_circle(motion)) {
      lines_.put_standing(counting);
    } else {
      lines_.put_place('X', piece.end_mm.x() - written_zero_mm_.x(), counting);
      lines_.put_place('Y', piece.end_mm.y() - written_zero_mm_.y(), counting);
    }
    if (is_whole) {
      lines_.put_word(block, 'Z');
    } else if (block.has('Z')) {
      const double rise_mm = *motion.to.z_mm - *motion.from.z_mm;
      lines_.put_height('Z', *motion.to.z_mm - (1 - piece.share) * rise_mm, counting);
    }
    if (!motion.is_arc()) lines_.put_word(block, 'R');
  }

  void put_center(const Piece& piece, const Vector2d& from_mm) {
    const Vector2d origin_mm =
        reader_.arcs_are_absolute() ? Vector2d(written_zero_mm_.head<2>()) : from_mm;
    lines_.put_offset('I', piece.center_mm.x() - origin_mm.x(), reader_.counting());
    lines_.put_offset('J', piece.center_mm.y() - origin_mm.y(), reader_.counting());
  }

  /// Of lines whose Z stands as the program has it.
  void follow_height(const Motion& motion) {
    Standing at = lines_.standing();
    const std::optional<double> to_mm =
        motion.kind == MotionKind::Cycle ? std::optional(motion.travel_mm) : motion.to.z_mm;
    at.z_mm =
        at.z_mm && motion.from.z_mm && to_mm ? *at.z_mm + (*to_mm - *motion.from.z_mm) : to_mm;
    lines_.stand_at(at);
  }

  // --- figures ---------------------------------------------------------------------------------

  Expected<void> note_places(const GcodeBlock& block, const Motion& motion) {
    if (motion.kind == MotionKind::Rapid || !motion.to.has_xy()) return {};
    if (motion.from.has_xy() && motion.kind != MotionKind::Cycle) {
      PANELCAL_CHECK(note(block, motion.from.xy_mm()));
    }
    constexpr int kOnArc = 8;
    for (int i = 1; motion.is_arc() && i < kOnArc; ++i) {
      PANELCAL_CHECK(note(block, gcode::place_mm(motion, static_cast<double>(i) / kOnArc)));
    }
    return note(block, motion.to.xy_mm());
  }

  Expected<void> note(const GcodeBlock& block, const Vector2d& program_mm) {
    const Vector2d nominal_mm = on_board(program_mm);
    const Vector2d actual_mm = places_.actual_mm(nominal_mm);
    figures_.nominal.add(position_mm<frame::Nominal>(nominal_mm));
    figures_.actual.add(position_mm<frame::Actual>(actual_mm));
    figures_.largest_shift = std::max(figures_.largest_shift, mm((actual_mm - nominal_mm).norm()));
    const Expected<Length> sigma = places_.sigma(nominal_mm);
    if (!sigma) {
      Diagnostic diagnostic = sigma.error();
      diagnostic.place = {program_.file, block.line, 1};
      return failure(std::move(diagnostic));
    }
    if (!(*sigma > figures_.largest_sigma)) return {};
    figures_.largest_sigma = *sigma;
    figures_.line_of_largest_sigma = block.line;
    return {};
  }

  void tell_progress(const SourceLine& line) {
    if (!options_.progress || ++n_lines_ % 1024 != 0) return;
    const auto at = line.text.data() - program_.bytes.data();
    options_.progress(static_cast<double>(at) / static_cast<double>(program_.bytes.size()));
  }

  const SourceText& program_;
  const BoardPlaces& places_;
  const MoveOptions& options_;
  MotionReader reader_;
  GcodeLines lines_{kDecimals};
  Eigen::Vector3d zero_mm_ = Eigen::Vector3d::Zero();          ///< of the program's coordinates
  Eigen::Vector3d written_zero_mm_ = Eigen::Vector3d::Zero();  ///< of the written ones
  std::optional<MotionKind> in_force_;  ///< of written arcs; empty: as the program has it
  std::string remark_;
  std::vector<int> source_lines_;
  std::size_t n_noted_ = 0;  ///< characters of the text whose lines are in source_lines_
  std::int64_t n_lines_ = 0;
  MoveFigures figures_;
};

}  // namespace

Expected<MovedGcode> move_gcode(const SourceText& program,
                                const BoardPlaces& places,
                                const MoveOptions& options) {
  return Mover(program, places, options).move();
}

}  // namespace panelcal
