// SPDX-License-Identifier: Apache-2.0
// Contours and figures of random SIEB & MEYER programs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/program/sieb_meyer/random_sm_lines.h"

namespace panelcal::test {

/// Writes lines that rout, and what they mean.
class SmContourWriter : protected SmLineWriter {
 protected:
  void begin_contour(Microns start) {
    modes();
    std::vector<SmWord> words = go_to(start);
    words.push_back(code("T0"));
    line(std::move(words));
    radius_um_ = 0;
    motion_.clear();
  }

  void end_contour() {
    std::vector<SmWord> words = go_to(at_);
    words.push_back(code("T0"));
    line(std::move(words));
  }

  std::string any_feed() const {
    const std::array<const char*, 3> tenths = {"F12", "F8", "F030"};
    const std::array<const char*, 3> metres = {"F1.2", "F.8", "F2500"};
    return job_.is_3000 ? any_of(tenths) : any_of(metres);
  }

  void rout_line(const SmPiece& piece, std::vector<SmWord> more) {
    const std::string motion = piece.turn == 0 ? "G1" : piece.turn < 0 ? "G2" : "G3";
    std::vector<SmWord> words = go_to(piece.to);
    if (motion != motion_) words.push_back(code(motion));
    if (motion_.empty() || one_in(6)) words.push_back(code(any_feed()));
    if (one_in(8)) words.push_back(code("G11"));
    words.insert(words.end(), more.begin(), more.end());
    motion_ = motion;
    line(std::move(words));
  }

  void contour() {
    SmNode node;
    node.kind = Kind::Contour;
    node.place = any_place();
    begin_contour(node.place);
    int side = one_in(3) ? (one_in(2) ? 1 : -1) : 0;
    for (int n = any(1, 4); n > 0; --n) {
      std::vector<SmWord> more;
      if (motion_.empty() && side != 0) more.push_back(code(side > 0 ? "G41" : "G42"));
      if (!motion_.empty() && one_in(8)) {
        more.push_back(code("G40"));
        side = 0;
      }
      const int kind = any(0, 3);
      SmPiece piece = kind == 0   ? arc_about_center(more)
                      : kind == 1 ? arc_of_radius(more)
                                  : straight();
      piece.side = side;
      rout_line(piece, more);
      node.pieces.push_back(std::move(piece));
    }
    end_contour();
    add(std::move(node));
  }

  /// A place that is not where the cutter stands.
  Microns elsewhere(int least_um, int most_um) {
    // Drawing again and again would never let a counterexample shrink.
    Microns step = any_place(most_um);
    if (norm(step) < least_um) step.x += 2 * least_um;
    return at_ + step;
  }

  SmPiece straight() { return {.to = elsewhere(1, 100'000)}; }

  SmPiece arc_of_radius(std::vector<SmWord>& more) {
    SmPiece piece{.turn = one_in(2) ? 1 : -1, .to = elsewhere(100, 30'000)};
    const double chord = norm(piece.to - at_);
    const auto least = static_cast<long>(std::ceil(0.51 * chord)) + 5;
    const bool still_holds = radius_um_ != 0 && std::abs(radius_um_) >= least;
    if (!still_holds || one_in(2)) {
      radius_um_ = (least + any(0, 40'000)) * (one_in(3) ? -1 : 1);
      more.push_back({"R", radius_um_});
    }
    piece.radius_um = radius_um_;
    return piece;
  }

  /// The end is a spoke turned or mirrored exactly, so that both ends are equally far.
  SmPiece arc_about_center(std::vector<SmWord>& more) {
    Microns spoke = any_place(20'000);
    if (norm(spoke) < 200) spoke.x += 400;
    if (std::abs(spoke.x) == std::abs(spoke.y)) spoke.x += spoke.x < 0 ? -1 : 1;
    const std::array<Microns, 7> ends = {{{-spoke.y, spoke.x},
                                          {-spoke.x, -spoke.y},
                                          {spoke.y, -spoke.x},
                                          {spoke.y, spoke.x},
                                          {-spoke.y, -spoke.x},
                                          {spoke.x, -spoke.y},
                                          {-spoke.x, spoke.y}}};
    Microns end = ends[static_cast<std::size_t>(any(0, 6))];
    if (end == spoke) end = ends[1];
    SmPiece piece{.turn = one_in(2) ? 1 : -1, .to = at_ - spoke + end, .spoke = spoke};
    radius_um_ = 0;
    more.push_back({"I", spoke.x});
    more.push_back({"J", spoke.y});
    return piece;
  }

  /// Straight lines whose corners are rounded where there is room for it.
  void rounded_contour() {
    SmNode node;
    node.kind = Kind::Contour;
    node.place = any_place();
    begin_contour(node.place);
    std::vector<Microns> corners = {node.place};
    for (int n = any(2, 4); n > 0; --n) {
      at_ = corners.back();
      corners.push_back(elsewhere(2000, 60'000));
    }
    at_ = node.place;
    for (std::size_t i = 1; i < corners.size(); ++i) {
      SmPiece piece{.to = corners[i]};
      std::vector<SmWord> more;
      if (i + 1 < corners.size())
        piece.corner_um = corner(corners[i - 1], corners[i], corners[i + 1]);
      if (piece.corner_um) more.push_back({"D", piece.corner_um});
      rout_line(piece, more);
      node.pieces.push_back(std::move(piece));
    }
    end_contour();
    add(std::move(node));
  }

  static std::optional<long> corner(Microns before, Microns at, Microns after) {
    const double half = angle_at(before, at, after) / 2;
    if (half < 0.25 || half > 1.3 || one_in(4)) return std::nullopt;
    const double room = 0.4 * std::min(norm(at - before), norm(after - at));
    return any(100, static_cast<int>(room * std::min(1.0, std::tan(half))));
  }

  void figures() {
    begin_contour(any_place());
    for (int n = any(1, 3); n > 0; --n) {
      SmNode node;
      node.kind = Kind::Figure;
      node.number = any(45, 50);
      node.place = elsewhere(1, 100'000);
      std::vector<SmWord> words = go_to(node.place);
      words.push_back(code("G" + std::to_string(node.number)));
      if (node.number < 49) {
        node.radius_um = any(2000, 20'000);
        words.push_back({"R", node.radius_um});
      } else if (one_in(3)) {
        node.second = {any(4000, 20'000), 0};
        node.second.y = node.second.x;
        words.push_back({"R", node.second.x});
      } else {
        node.second = {any(4000, 20'000), any(4000, 20'000)};
        words.push_back({"I", node.second.x});
        words.push_back({"J", node.second.y});
      }
      const bool has_inside = node.number != 47 && node.number != 48;
      if (!job_.is_3000 && has_inside && one_in(6)) words.push_back(code("G43"));
      line(std::move(words));
      add(std::move(node));
    }
    end_contour();
  }

 private:
  std::string motion_;  ///< of this contour's last line
  long radius_um_ = 0;  ///< R that holds in this contour; 0: none
};

}  // namespace panelcal::test
