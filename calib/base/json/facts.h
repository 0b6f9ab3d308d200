// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

// Not installed: public headers know nothing of JSON.
namespace panelcal::facts {

/// A document of facts: members stay in the order in which they were stated.
using Json = nlohmann::ordered_json;

/// The head of every document: {"facts": "job", "version": 1, "panelcal": "0.1.0"}.
///
/// In     kind: the word that share/schema/KIND.schema.json is named by
///        version: of that schema; it grows when a key changes its meaning or goes
Json envelope(std::string_view kind, int version);

/// Null where the value is not finite, which JSON cannot write.
Json number(double value);
/// Null as well where there is no value.
Json number(const std::optional<double>& value);
/// [x, y]; the key states the unit.
Json point(const Eigen::Vector2d& value);
/// [xx, xy, yy] of a symmetric matrix; the key states the unit.
Json covariance(const Eigen::Matrix2d& value);

/// A column of a table of many rows: {"type": "float32", "base64": "..."}, values little-endian
/// one behind the other. Values that are not finite stay as they are.
Json packed(std::span<const float> values);
Json packed(std::span<const std::uint32_t> values);

/// The document as text, with a line end. Bytes that are no UTF-8 become U+FFFD.
std::string text(const Json& document);

/// The mark before the document in a page of tools/page/page.h; `</script>` stands behind it.
inline constexpr std::string_view kPageMark = "<script type=\"application/json\" id=\"facts\">";

/// The document of such a page; empty for any other text.
std::string_view in_page(std::string_view html);

/// RFC 4648 with padding, without line breaks.
std::string base64(std::string_view bytes);

}  // namespace panelcal::facts
