// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "calib/base/files/file_descriptor.h"

namespace panelcal {

enum class GrblFault { None, Close, Silence, Garbage, Error, Alarm, Reset, Hold, Door };

/// A GRBL 1.1 on a free port of 127.0.0.1, from the public description of its interface: states,
/// `?`, `!`, `~`, 0x18, 0x85, `$I $$ $# $G $H $X $J=`, G38.2, and modes that are only kept. Its
/// moves take time, so that they can be stopped on their way.
class FakeGrbl {
 public:
  struct Setting {
    std::string identity = "[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\n";
    std::string state = "Idle";
    std::string modes = "G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0";
    std::string offsets = "[G54:0.000,0.000,0.000]\r\n[G92:0.000,0.000,0.000]\r\n[TLO:0.000]\r\n";
    std::string extra;       ///< of each report, such as "|H:0"
    std::string full_extra;  ///< of the answer to 0x87, which comes behind a report without it
    std::string half_line;   ///< what another program has left behind
    bool inches = false;     ///< $13
    bool work_only = false;  ///< $10=0: WPos, and WCO in each fourth report
    bool homing = true;      ///< $22
    bool greets = true;      ///< each connection
    double travel_mm = 200;
    std::array<double, 3> offset_mm{};  ///< of work zero
    std::array<double, 3> at_mm{-100, -100, -1};
    double mm_s = 20000;
    double surface_mm = -12.34;  ///< where the probe touches
    bool probe_is_tripped = false;
    bool probe_sticks = false;  ///< stays tripped after a touch
    GrblFault fault = GrblFault::None;
    /// The message, from 1, that the fault answers; each line and each `?` is one.
    int at_message = 0;
  };

  explicit FakeGrbl(Setting setting);
  FakeGrbl(const FakeGrbl&) = delete;
  FakeGrbl& operator=(const FakeGrbl&) = delete;
  ~FakeGrbl();

  int port() const { return port_; }
  /// All lines and single bytes that came, `?` and the line `$` left out.
  std::vector<std::string> received() const;
  int n_messages() const { return n_messages_; }
  /// The place that a move, if there is one, ends at if it is not stopped.
  std::array<double, 3> end_mm() const;
  bool is_moving() const;
  std::string modes() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Move {
    std::array<double, 3> from, to;
    Clock::time_point begin;
    double s = 0;
    bool is_jog = false;
    bool is_probing = false;
  };

  void serve();
  void take(char byte);
  void take_line(const std::string& line);
  bool is_struck();
  void strike();
  void advance();
  void stop_move();
  void begin_move(std::array<double, 3> to, bool is_jog, bool is_probing, double mm_s);
  void jog(const std::string& words);
  void probe(const std::string& words);
  void say(std::string_view line);
  void report(std::string_view extra = {});
  std::string settings() const;
  std::string place(std::array<double, 3> mm) const;

  Setting setting_;
  internal::FileDescriptor listener_, peer_, wake_read_, wake_write_;
  int port_ = 0;
  mutable std::mutex mutex_;
  std::vector<std::string> received_;
  std::string line_;
  std::array<double, 3> at_mm_{};
  std::optional<Move> move_;
  int n_reports_ = 0;
  std::atomic<int> n_messages_ = 0;
  bool is_silent_ = false;
  std::jthread thread_;
};

}  // namespace panelcal
