// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// The page of `panelcal serve`: example, explanation and exit codes.
namespace panelcal::pages {

inline constexpr std::string_view kServe = R"(Example
  $ panelcal serve -m machine.toml --camera v4l2:/dev/video0
  http://127.0.0.1:8330/
  $ panelcal serve -m machine.toml --camera v4l2:/dev/video0 --address 192.168.1.20:8330 \
      --token-file /var/lib/panelcal/token --certificate cert.pem --key key.pem
  https://192.168.1.20:8330/
  token: 7f3k...
  It is printed this once; /var/lib/panelcal/token keeps a hash of it.

Open the address in a browser: it shows the camera's picture, the targets of the job on the panel,
and what the machine asks where it does not find one. Any number of people may look (64 screens);
one at a time takes the controls and operates. The state is the job's, not the browser's: a reload
or a lost connection changes nothing, and a job that was cut off goes on where it stopped.

--jobs has a folder programs with the programs that may be opened, which uploads add to, and a folder
for each job with its measurements, report and output. Nothing outside of it is shown or written but
what machine.toml names.

Who can reach the address can look, so the default is this computer alone. Any other address needs
--token-file: each browser has to show the token once a working day. It also needs --certificate and
--key, or the word --plain-http. A lost token: delete the file; the next start makes another one.
A browser that calls the server by a name (http://drill1:8330/) is refused unless --host-name drill1
lists it: a stranger's page could otherwise use a name of its own for this address.
docs/howto/serve.md says how to set it up, how to run it from systemd, and what it protects against.

Exit codes
  0 ended by SIGINT, SIGTERM or SIGHUP: screens are told, what moves is halted, the job stays
  resumable; 2 bad input or usage, such as an address in use; 3 a device or the disk failed)";

}  // namespace panelcal::pages
