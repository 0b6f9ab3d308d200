// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace panelcal::report {

/// `text` as it can stand in HTML, between tags and inside quoted attributes. Valid UTF-8 stays;
/// control and stray bytes become \xNN, so that no input can break the page.
std::string escaped(std::string_view text);

/// RFC 4648 with padding, without line breaks.
std::string base64(std::string_view bytes);

/// Fixed point, "0.0" rather than "-0.0"; "not a number" where it is NaN.
std::string fixed(double value, int n_decimals);
/// The same with a sign, also in front of positive numbers.
std::string fixed_signed(double value, int n_decimals);
/// In the fewest digits, at most six of them: 0.5, 2,000, 61.3; thousands are grouped.
std::string shortest(double value);
/// 20,000
std::string grouped(std::int64_t n);
/// "1 hole", "20,000 holes"
std::string counted(std::int64_t n, std::string_view noun);

/// Value and standard deviation with the decimals that show two digits of the latter, as HTML:
/// "+201.20 &#177; 0.92 ppm".
std::string with_sigma(double value, double sigma, std::string_view unit, bool is_signed = true);

/// "(15.000, 89.026)"
std::string point_text(const Eigen::Vector2d& p_mm);
/// "[0,1]", the step-and-repeat indices as everywhere else; empty for the panel itself.
std::string path_text(std::span<const int> path);

/// A cell of a table, set like a number; `text` is HTML already.
std::string number_cell(std::string_view text);

/// "line 14 of p.exc, board 2, nominal (1.000, 2.000) mm".
///
/// In     file: another one than the program's, or empty
std::string place_html(int line,
                       std::string_view file,
                       std::span<const int> path,
                       const Eigen::Vector2d& nominal_mm);

/// A probability: "6.3 &#215; 10<sup>-5</sup>".
std::string risk_html(double risk);

}  // namespace panelcal::report
