// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "program/model/operation.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/walk/reporter.h"

namespace panelcal::sieb_meyer {

/// The meaning of the letters I, J, P, W, E and R in a line.
enum class ParameterKind : std::uint8_t {
  Rout,   ///< of a contour or figure
  Peck,   ///< of G81
  Pulse,  ///< of G89
};

/// All that one line asks for. Commands act on the line they stand in, wherever they stand, and of
/// contradicting ones the last holds: so a line is read whole before anything is done.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 1 Working method; A.3
struct Order {
  std::array<std::optional<double>, 2> xy_mm;
  double xy_step_mm = 0;  ///< of one in the coarser last digit

  std::optional<int> tool;     ///< above 0
  bool is_tool_up = false;     ///< T0
  bool is_dummy_tool = false;  ///< TD

  std::optional<Command> motion;   ///< G1 to G3, G45 to G50
  std::optional<Command> nibble;   ///< G84, G85
  std::optional<Command> camera;   ///< G30 to G36
  std::optional<Command> surface;  ///< G72 to G79 but G77
  std::optional<Command> area;     ///< M56 to M58
  std::optional<Command> stop;     ///< M28, M29
  std::optional<Command> text;     ///< the last word, which takes a text
  std::optional<CompensationSide> side;
  std::optional<bool> incremental;
  std::optional<bool> is_scaled;
  std::optional<bool> depth_control;
  bool suspends_depth_control = false;  ///< G82, and neither G83 nor G71 behind it in the line
  std::optional<bool> slm;              ///< G71, G70
  std::optional<bool> peck;
  std::optional<bool> pulse;
  std::optional<bool> checks_breakage;
  bool is_ramp = false;
  bool clears_area = false;
  bool finishes = false;  ///< G11
  bool skips_surface = false;
  bool may_stop = false;  ///< M20
  std::vector<Command> functions;

  std::optional<int> v;
  std::optional<int> memory;  ///< L
  std::optional<int> count;   ///< W of a pattern
  ParameterKind parameters = ParameterKind::Rout;
  std::optional<double> r_mm;
  std::array<std::optional<double>, 2> ij_mm;
  double parameter_step_mm = 0;
  std::optional<double> percent;      ///< P
  std::optional<double> permille;     ///< W
  std::optional<double> dwell_ms;     ///< E
  std::optional<double> rounding_mm;  ///< D
  std::optional<double> feed_m_min;
  std::optional<double> h_mm;
  std::optional<double> k_mm;
  std::optional<double> z_mm;

  bool has_xy() const { return xy_mm[0] || xy_mm[1]; }
};

/// The parts of a line that only some tasks can use.
enum Part : std::uint32_t {
  kXy = 1U << 0U,
  kMotion = 1U << 1U,
  kNibble = 1U << 2U,
  kCamera = 1U << 3U,
  kSurface = 1U << 4U,
  kArea = 1U << 5U,
  kPattern = 1U << 6U,
  kMemory = 1U << 7U,
  kCount = 1U << 8U,
  kToolUp = 1U << 9U,
  kDummyTool = 1U << 10U,
  kSide = 1U << 11U,
  kRamp = 1U << 12U,
  kCutArea = 1U << 13U,
  kFinish = 1U << 14U,
  kRounding = 1U << 15U,
  kParameters = 1U << 16U,  ///< R, I, J of contours
  kText = 1U << 17U,
};

/// The parts that a line has.
std::uint32_t parts_of(const Order& order);
/// Notation of a part, for messages. Precondition: one bit.
std::string_view form_of(std::uint32_t part);

/// The settings that decide how a line's letters are read.
struct OrderContext {
  ProgramFormat format;
  bool is_routing = false;     ///< a routing function is in force
  bool expects_count = false;  ///< a V pattern waits for its W
  bool is_pecking = false;     ///< G81 is in force
  bool is_pulsing = false;
};

/// Reads a line's words. Brackets and offsets are left to the sections; absent after an error.
///
/// Fails  into the reporter: command-unknown, command-format, number-malformed, argument-invalid,
///        camera-not-last; warns word-repeated
std::optional<Order> read_order(const Block& block,
                                const OrderContext& context,
                                const Reporter& reporter);

}  // namespace panelcal::sieb_meyer
