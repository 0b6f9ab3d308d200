// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

// Not installed. fmt::format_to with an iterator compiles all that fmt can write again in every
// unit that calls it; this compiles it once.
namespace panelcal::internal {

/// Appends `values`, written as `text` says.
void append_values(std::string& out, fmt::string_view text, fmt::format_args values);

template <typename... Values>
void append_format(std::string& out, fmt::format_string<Values...> text, Values&&... values) {
  append_values(out, text, fmt::make_format_args(values...));
}

/// The numbers one after the other, as fmt::join writes them.
std::string joined(std::span<const double> numbers, std::string_view between);

}  // namespace panelcal::internal
