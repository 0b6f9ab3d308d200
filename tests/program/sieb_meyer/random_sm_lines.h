// SPDX-License-Identifier: Apache-2.0
// Lines of random SIEB & MEYER programs, and the state that they leave.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/program/sieb_meyer/random_draws.h"

namespace panelcal::test {

inline SmWord code(std::string text) {
  return {std::move(text)};
}

/// Writes lines, and keeps what a program has said so far.
class SmLineWriter {
 protected:
  using Kind = SmNode::Kind;

  /// A line with a coordinate; what waits to be said comes with it.
  void line(std::vector<SmWord> words, std::string tail = {}, bool is_slashed = false) {
    words.insert(words.end(), prefix_.begin(), prefix_.end());
    prefix_.clear();
    plain_line(std::move(words), std::move(tail), is_slashed);
  }
  void plain_line(std::vector<SmWord> words, std::string tail = {}, bool is_slashed = false) {
    job_.lines.push_back({std::move(words), std::move(tail), is_slashed, any(0, 1 << 20)});
  }
  SmNode& add(SmNode node) {
    nodes_->push_back(std::move(node));
    return nodes_->back();
  }

  /// X and Y that lead to a place, as the mode asks for them; at least one of them.
  std::vector<SmWord> go_to(Microns place, bool in_full = false) {
    const Microns from = incremental_ ? at_ : Microns{};
    in_full |= std::exchange(is_behind_section_, false) && !incremental_;
    std::vector<SmWord> words;
    const bool says_x = place.x != at_.x || in_full || one_in(2);
    const bool says_y = place.y != at_.y || in_full || !says_x || one_in(2);
    if (says_x) words.push_back({"X", place.x - from.x});
    if (says_y) words.push_back({"Y", place.y - from.y});
    at_ = place;
    return words;
  }

  /// Adds words that may stand in any line that drills or begins a contour, and holds for it
  /// already.
  void modes() {
    if (one_in(6)) {
      incremental_ = !incremental_;
      prefix_.push_back(code(incremental_ ? "G91" : "G90"));
    }
    const bool has_tool =
        std::ranges::any_of(prefix_, [](const SmWord& word) { return word.text.starts_with('T'); });
    if (!has_tool && one_in(5)) take_any_tool();
    if (one_in(5)) plane();
    if (one_in(12)) prefix_.push_back(code("M21"));
    if (!job_.is_3000 && one_in(12)) prefix_.push_back(code(one_in(2) ? "M94" : "M95"));
  }

  void take_any_tool() {
    SmNode node;
    node.kind = Kind::Tool;
    node.number = any(1, static_cast<int>(kSmTools_um.size()));
    prefix_.push_back(code("T" + std::to_string(node.number)));
    add(std::move(node));
  }

  void plane() {
    SmNode node;
    node.kind = Kind::Plane;
    const long step_um = job_.is_3000 ? 10 : 1;
    if (one_in(2)) {
      node.z_um = any(0, 300) * 10;
      prefix_.push_back({"Z", node.z_um, step_um});
    }
    if (one_in(2)) {
      node.k_um = any(0, 300) * 10;
      prefix_.push_back({"K", node.k_um, step_um});
    }
    if (one_in(2)) {
      node.depth_control = one_in(2);
      prefix_.push_back(code(*node.depth_control ? "G83" : "G82"));
    }
    add(std::move(node));
  }

  /// Lines that neither move nor change where anything goes.
  void idle_line() {
    const std::array<const char*, 3> orders_of_both = {"", "M20", "M47,HELLO (YOU)"};
    const std::array<const char*, 6> orders = {
        "M34", "M47 TURN", "M49,COMM,E", "M76,A1", "M49,M101", "G80"};
    const std::string tail = job_.is_3000 || one_in(3) ? any_of(orders_of_both) : any_of(orders);
    plain_line({}, tail);
  }

  SmJob job_;
  std::vector<SmNode>* nodes_ = nullptr;
  std::vector<SmWord> prefix_;  ///< of the next line with a coordinate
  Microns at_;
  bool incremental_ = false;
  bool is_behind_section_ = false;  ///< where absolute lines need both axes
};

}  // namespace panelcal::test
