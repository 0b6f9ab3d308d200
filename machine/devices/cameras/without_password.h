// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace panelcal {

/// A camera's address as it may stand in a report: without what stands before the @ of a host, a
/// name and a password. Other text stays as it is.
std::string without_password(std::string_view uri);

}  // namespace panelcal
