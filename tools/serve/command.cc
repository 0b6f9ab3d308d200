// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/interruption.h"
#include "tools/cli/commands.h"
#include "tools/cli/process/version.h"
#include "tools/page/page.h"
#include "tools/serve/access/token_file.h"
#include "tools/serve/front_end.h"
#include "tools/serve/served_station.h"
#include "tools/serve/server.h"
#include "tools/serve/settings.h"
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal {
namespace {

using serve::AccessSettings;
using serve::Listener;

/// What a person opens, and the token if it is new.
std::string greeting(const Listener& listener,
                     const AccessSettings& access,
                     const std::string& token) {
  const char* const scheme = access.certificate.empty() ? "http" : "https";
  std::string text;
  for (const std::string& host : access.host_names) {
    text += fmt::format("{}://{}:{}/\n", scheme, host, listener.port());
  }
  for (const std::string& address : listener.reachable_at()) {
    text += fmt::format("{}://{}/\n", scheme, address);
  }
  if (!token.empty()) {
    text += fmt::format(
        "token: {}\nIt is printed this once; {} keeps a hash of it.\n", token, access.token_file);
  }
  return text;
}

Expected<std::unique_ptr<Station>> open_station(const ServeOptions& options) {
  StationSettings settings;
  settings.machine_file = options.machine;
  settings.jobs_folder = options.jobs.empty()
                             ? std::filesystem::path(options.machine).parent_path() / "jobs"
                             : std::filesystem::path(options.jobs);
  settings.camera = options.camera;
  settings.images = options.images;
  settings.machine_driver = options.machine_driver;
  settings.page = &page_html;
  settings.software = fmt::format("panelcal {}", kVersion);
  return Station::create(std::move(settings));
}

}  // namespace

Expected<Answer> run_command(const ServeOptions& options, CommandContext& context) {
  const AccessSettings access{.token_file = options.token_file,
                              .certificate = options.certificate,
                              .key = options.key,
                              .allows_plain_http = options.allows_plain_http,
                              .host_names = options.host_names};
  PANELCAL_TRY(const Listener listener, Listener::open(options.address));
  PANELCAL_CHECK(serve::check_access(access, listener));
  std::shared_ptr<serve::TlsIdentity> identity;
  if (!access.certificate.empty()) {
    PANELCAL_TRY(identity, serve::open_tls_identity(access.certificate, access.key));
  }
  serve::load_protocol();
  heed_interruptions();
  PANELCAL_TRY(auto station, open_station(options));
  // Last, so that a token is made only by a server that begins.
  std::optional<serve::Login> login;
  std::string new_token;
  if (!access.token_file.empty()) {
    PANELCAL_TRY(serve::OpenedToken token, serve::open_token_file(access.token_file));
    login.emplace(std::move(token.token));
    new_token = std::move(token.made);
  }
  serve::ServedStation machine(std::move(station));
  serve::Controls controls;
  serve::Announcer announcer(machine, controls);
  serve::Service service({.machine = machine,
                          .controls = controls,
                          .announcer = announcer,
                          .login = login ? &*login : nullptr,
                          .host_names = access.host_names,
                          .front_end = serve::front_end()});
  if (auto said = context.output.write(greeting(listener, access, new_token)); !said) {
    // Else the token would be lost, since no one has seen it.
    if (!new_token.empty()) ::unlink(access.token_file.c_str());
    return failure(std::move(said).error());
  }
  serve::run_server(listener, identity.get(), service, announcer, interruption_fd());
  return Answer{};
}

}  // namespace panelcal
