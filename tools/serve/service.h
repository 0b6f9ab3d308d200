// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/serve/access/controls.h"
#include "tools/serve/access/login.h"
#include "tools/serve/announcer.h"
#include "tools/serve/http/message.h"
#include "tools/serve/http/target.h"
#include "tools/serve/served_machine.h"

namespace panelcal::serve {

/// The pages that a browser gets before anything else.
struct FrontEnd {
  std::string_view page;
  std::string_view script;
  std::string_view style;
};

/// All routes of `panelcal serve`, as functions of plain requests (docs/howto/serve.md has the
/// list).
///
/// A request passes, in this order: its form; Host; Origin and Sec-Fetch-Site; route and method;
/// the login where a token is needed; type and size of its body; the controls where it changes
/// anything. What is refused changes nothing.
///
/// See    tests/tools/serve/service_test.cc, tests/tools/serve/fuzz_test.cc
class Service final : public HttpService {
 public:
  static constexpr std::size_t kMaxCommand_bytes = std::size_t{64} << 10;
  static constexpr std::size_t kMaxProgram_bytes = std::size_t{64} << 20;

  struct Parts {
    ServedMachine& machine;
    Controls& controls;
    Announcer& announcer;
    Login* login = nullptr;               ///< null: no token is needed
    std::vector<std::string> host_names;  ///< besides the address at which a request arrives
    FrontEnd front_end;
    std::function<Now()> now = [] { return std::chrono::steady_clock::now(); };
  };
  explicit Service(Parts parts) : parts_(std::move(parts)) {}

  std::variant<Response, std::size_t> admit(const Request& head) override;
  Response handle(const Request& request) override;
  Response refuse(int status) override;

 private:
  struct Route;
  struct Admitted {
    const Route* route;
    Target target;
  };
  static const Route* find_route(const Target& target);

  std::variant<Response, Admitted> examine(const Request& head);
  std::optional<Response> check_site(const Request& head, const Target& target) const;
  std::optional<Response> check_login(const Request& head) const;
  static std::optional<Response> check_body(const Request& head, const Route& route);

  Response page(const Request& request, const Target& target);
  Response script(const Request& request, const Target& target);
  Response style(const Request& request, const Target& target);
  Response state(const Request& request, const Target& target);
  Response events(const Request& request, const Target& target);
  Response picture(const Request& request, const Target& target);
  Response calibration_page(const Request& request, const Target& target);
  Response job_file(const Request& request, const Target& target);
  Response send_file(const std::string& job_id, const std::string& name);
  Response log_in(const Request& request, const Target& target);
  Response log_out(const Request& request, const Target& target);
  Response change_controls(const Request& request, const Target& target);
  Response command(const Request& request, const Target& target);
  Response add_program(const Request& request, const Target& target);

  Parts parts_;
  /// Files of jobs on their way, which may be large: no more than kMaxFiles at a time.
  static constexpr int kMaxFiles = 4;
  std::shared_ptr<std::atomic<int>> n_files_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace panelcal::serve
