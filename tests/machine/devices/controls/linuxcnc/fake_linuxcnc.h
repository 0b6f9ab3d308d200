// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "calib/base/files/file_descriptor.h"
#include <Eigen/Core>

namespace panelcal::test {

/// What goes wrong at one request.
enum class CncFault : std::uint8_t {
  None,
  Close,       ///< the connection ends; a new one is served
  Gone,        ///< it ends, and nothing listens any more
  Silence,     ///< no answer to this request
  Garbage,     ///< another answer than was asked for
  Nak,         ///< a `set` is refused; of a `get`: `GET X NAK`
  Estop,       ///< the emergency stop is pressed
  Limit,       ///< joint 1 runs into its limit switch
  Fault,       ///< a servo reports a fault
  Pause,       ///< the operator pauses
  Hold,        ///< feed hold: it runs and does not go on
  Mode,        ///< the operator changes to manual
  Steal,       ///< another client takes the control
  Error,       ///< the control ends the move with a text
  ProbeStuck,  ///< the probe touches from now on
};

/// A machine behind linuxcncrsh's protocol, on a port of loopback: it moves 2 m/s, knows one work
/// offset, and trips its probe at a surface.
///
/// Source linuxcncrsh(1), and answers seen of LinuxCNC 2.9
class FakeLinuxCnc {
 public:
  struct Setting {
    bool is_inch = false;
    bool is_homed = true;
    std::string codes = "G0 G17 G40 G21 G90 G94 G54 G49 G99 G64 G97 G91.1 G8 G92.2 F0 S0";
    Eigen::Vector3d encoder_mm = Eigen::Vector3d::Zero();  ///< encoder minus command
    /// Z of the surface at a place; far below: nothing to touch.
    std::function<double(double, double)> surface_mm = [](double, double) { return -1e3; };
    int fault_at = -1;      ///< the number of the request, from 0
    int fault_in_move = 0;  ///< the number of the move, from 1, at whose first request after it
    CncFault fault = CncFault::None;
    std::function<void()> at_fault = [] {};  ///< called just before it
  };

  explicit FakeLinuxCnc(Setting setting);
  FakeLinuxCnc(const FakeLinuxCnc&) = delete;
  FakeLinuxCnc& operator=(const FakeLinuxCnc&) = delete;
  ~FakeLinuxCnc();

  int port() const { return port_; }
  int n_requests() const { return n_requests_; }
  Eigen::Vector3d place_mm();
  bool moves();
  /// All MDI lines, in order.
  std::vector<std::string> lines();
  bool was_low_in_xy();  ///< X or Y was to move with Z below -5 mm
  void set(const std::function<void(FakeLinuxCnc&)>& change);

  // Under the lock of set().
  bool estop = false;
  bool is_on = true;
  std::string mode = "MANUAL";
  std::string status_word;  ///< not empty: instead of what the motion says
  bool has_program = false;
  bool probe_is_stuck = false;
  std::string connect_password = "EMC";
  std::string enable_password = "EMCTOO";

 private:
  using Clock = std::chrono::steady_clock;
  struct Motion {
    Eigen::Vector3d from = Eigen::Vector3d::Zero();
    Eigen::Vector3d to = Eigen::Vector3d::Zero();
    Clock::time_point start;
    double duration_s = 0;
    bool trips = false;
  };
  struct Client {
    int fd = -1;
    bool is_linked = false;
    bool has_echo = true;
    bool is_verbose = false;
    std::string received;
  };

  void serve();
  bool answer(Client& client, const std::string& line);
  std::string set_answer(Client& client, const std::string& words);
  std::string get_answer(const Client& client, const std::string& subject);
  void mdi(const std::string& line);
  void start(const Eigen::Vector3d& to, double duration_s, bool trips);
  Eigen::Vector3d now() const;
  bool is_moving() const;
  void halt();
  void strike(CncFault fault);

  Setting setting_;
  std::mutex mutex_;
  internal::FileDescriptor listener_;
  int port_ = 0;
  std::atomic<int> n_requests_ = 0;
  std::atomic<bool> ends_ = false;
  Motion motion_;
  bool is_held_ = false;
  bool is_relative_ = false;
  double mm_per_word_ = 1;
  bool tripped_ = false;
  double touch_mm_ = 0;
  int owner_ = -1;
  int n_moves_ = 0;
  std::string error_;
  std::string joint_limit_ = "OK OK OK OK OK OK";
  std::string joint_fault_ = "OK OK OK OK OK OK";
  std::vector<std::string> lines_;
  bool was_low_ = false;
  std::thread thread_;
};

}  // namespace panelcal::test
