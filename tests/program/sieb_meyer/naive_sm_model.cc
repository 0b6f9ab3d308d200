// SPDX-License-Identifier: Apache-2.0
#include "tests/program/sieb_meyer/naive_sm_model.h"

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <numbers>
#include <string>

namespace panelcal::test {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Vector2d mm_of(Microns p) {
  return {static_cast<double>(p.x) / 1000, static_cast<double>(p.y) / 1000};
}

double mm_of(long um) {
  return static_cast<double>(um) / 1000;
}

/// The worked positions of chapter 5.5: what becomes of (x, y) in front of the offset.
Matrix2d orientation_of(const std::string& codes) {
  const auto matrix = [](double a, double b, double c, double d) {
    Matrix2d m;
    m << a, b, c, d;
    return m;
  };
  static const std::map<std::string, Matrix2d> table = {
      {"50", matrix(1, 0, 0, 1)},
      {"60", matrix(0, -1, 1, 0)},
      {"70", matrix(-1, 0, 0, 1)},
      {"80", matrix(1, 0, 0, -1)},
      {"90", matrix(-1, 0, 0, -1)},
      {"6070", matrix(0, 1, 1, 0)},
      {"6080", matrix(0, -1, -1, 0)},
      {"6090", matrix(0, 1, -1, 0)},
  };
  return table.at(codes);
}

struct Frame {
  Matrix2d linear = Matrix2d::Identity();
  Vector2d offset_mm = Vector2d::Zero();

  Vector2d operator()(const Vector2d& p) const { return linear * p + offset_mm; }
  bool is_mirror() const { return linear(0, 0) * linear(1, 1) < linear(0, 1) * linear(1, 0); }
};

class Model {
 public:
  explicit Model(const BoardMap& board) : board_(board) {}

  void run(const std::vector<SmNode>& nodes, const Frame& frame) {
    for (const SmNode& node : nodes) run(node, frame);
  }
  std::vector<NaiveEvent> take() { return std::move(events_); }

 private:
  void run(const SmNode& node, const Frame& frame) {
    using enum SmNode::Kind;
    switch (node.kind) {
      case Tool:
        tool_ = node.number;
        return;
      case Plane:
        if (node.z_um) z_mm_ = mm_of(*node.z_um);
        if (node.k_um) k_mm_ = mm_of(*node.k_um);
        if (node.depth_control) depth_control_ = *node.depth_control;
        return;
      case Hole:
        return hole(frame(mm_of(node.place)), 0);
      case TargetHole: {
        hole(frame(mm_of(node.place)), 0);
        events_.back().at_mm = board_(events_.back().nominal_mm);
        return;
      }
      case Pattern:
        return pattern(node, frame);
      case Contour:
        return contour(node, frame);
      case Figure:
        return figure(node, frame);
      case Correction:
        corrects_ = node.is_on;
        return;
      case Section:
        if (node.copies.empty()) return run(node.body, frame);
        for (const auto& [codes, zero] : node.copies) {
          // The offset is a place of the section around it.
          run(node.body, {frame.linear * orientation_of(codes), frame(mm_of(zero))});
        }
        return;
    }
  }

  Vector2d corrected(const Vector2d& nominal_mm) const {
    return corrects_ ? board_(nominal_mm) : nominal_mm;
  }

  NaiveEvent event(NaiveEvent::Kind kind) const {
    NaiveEvent out;
    out.kind = kind;
    out.tool = tool_;
    if (depth_control_) {
      out.cut.is_controlled = true;
      out.cut.depth_mm = k_mm_;
      out.cut.lower_limit_mm = z_mm_;
    } else {
      out.cut.z_mm = z_mm_;
    }
    return out;
  }

  void hole(const Vector2d& nominal_mm, int group) {
    NaiveEvent out = event(NaiveEvent::Kind::Hole);
    out.nominal_mm = nominal_mm;
    out.at_mm = corrected(nominal_mm);
    out.group = group;
    events_.push_back(out);
  }

  // --- chapter 2.5 ---

  void pattern(const SmNode& node, const Frame& frame) {
    const Vector2d a = mm_of(node.place);
    const Vector2d b = mm_of(node.second);
    if (node.number == 2) {
      const int n = *node.n_in_row;
      for (int i = 0; i < n; ++i) hole(frame(a + (b - a) * i / (n - 1)), 0);
      return;
    }
    const int group = ++n_groups_;
    if (node.number == 4) {
      const int n = *node.n_in_row;
      const double radius_mm = (b - a).norm();
      const double start_rad = std::atan2(b.y() - a.y(), b.x() - a.x());
      for (int i = 0; i < n; ++i) {
        const double angle = start_rad + 2 * std::numbers::pi * i / n;
        hole(frame(a + radius_mm * Vector2d(std::cos(angle), std::sin(angle))), group);
      }
      return;
    }
    grid(node, frame, group);
  }

  /// V1 and V3: a falling diagonal has its rows along x, a rising one along y.
  void grid(const SmNode& node, const Frame& frame, int group) {
    const Vector2d a = mm_of(node.place);
    const Vector2d diagonal = mm_of(node.second) - a;
    const bool along_x = diagonal.x() * diagonal.y() < 0;
    const double length = along_x ? diagonal.x() : diagonal.y();
    const double pitch = node.n_in_row ? std::abs(length) / (*node.n_in_row - 1) : 2.54;
    const auto n_x = std::lround(std::abs(diagonal.x()) / pitch);
    const auto n_y = std::lround(std::abs(diagonal.y()) / pitch);
    const double step_x = std::copysign(pitch, diagonal.x());
    const double step_y = std::copysign(pitch, diagonal.y());
    for (long i = 0; i <= n_x; ++i) {
      for (long j = 0; j <= n_y; ++j) {
        const bool on_side_x = j == 0 || j == n_y;
        const bool on_side_y = i == 0 || i == n_x;
        const bool in_rows = along_x ? on_side_x : on_side_y;
        if (!(node.number == 1 ? in_rows : on_side_x || on_side_y)) continue;
        hole(frame(a + Vector2d(step_x * static_cast<double>(i), step_y * static_cast<double>(j))),
             group);
      }
    }
  }

  // --- chapter 3 ---

  void contour(const SmNode& node, const Frame& frame) {
    Vector2d from = mm_of(node.place);
    Vector2d programmed = from;  // the corner, where it was rounded off
    for (std::size_t i = 0; i < node.pieces.size(); ++i) {
      const SmPiece& piece = node.pieces[i];
      const Vector2d to = mm_of(piece.to);
      if (piece.corner_um) {
        rounded(piece, node.pieces[i + 1], programmed, from, frame);
      } else if (piece.turn == 0) {
        rout(from, to, nullptr, 0, piece.side, frame);
        from = to;
      } else {
        const Vector2d center = center_of(piece, from, to);
        rout(from, to, &center, piece.turn, piece.side, frame);
        from = to;
      }
      programmed = to;
    }
  }

  static Vector2d center_of(const SmPiece& piece, const Vector2d& from, const Vector2d& to) {
    if (piece.spoke) return from - mm_of(*piece.spoke);
    const Vector2d chord = to - from;
    const Vector2d left = Vector2d(-chord.y(), chord.x()).normalized();
    const double r = std::abs(mm_of(piece.radius_um));
    const double height = std::sqrt(r * r - chord.squaredNorm() / 4);
    // Counterclockwise the short way turns about a point on the left, the long way on the right.
    const double side = piece.turn * (piece.radius_um < 0 ? -1 : 1);
    return (from + to) / 2 + side * height * left;
  }

  /// The arc touches both lines where they are r / tan(angle / 2) away from their corner.
  void rounded(const SmPiece& piece,
               const SmPiece& next,
               const Vector2d& before,
               Vector2d& from,
               const Frame& frame) {
    const Vector2d corner = mm_of(piece.to);
    const Vector2d back = (before - corner).normalized();
    const Vector2d ahead = (mm_of(next.to) - corner).normalized();
    const double r = mm_of(*piece.corner_um);
    const double half = std::acos(back.dot(ahead)) / 2;
    const Vector2d begin = corner + r / std::tan(half) * back;
    const Vector2d end = corner + r / std::tan(half) * ahead;
    const Vector2d center = corner + r / std::sin(half) * (back + ahead).normalized();
    const double turns_left = ahead.x() * back.y() - ahead.y() * back.x();
    rout(from, begin, nullptr, 0, piece.side, frame);
    rout(begin, end, &center, turns_left > 0 ? 1 : -1, piece.side, frame);
    from = end;
  }

  void rout(const Vector2d& from,
            const Vector2d& to,
            const Vector2d* center,
            int turn,
            int side,
            const Frame& frame) {
    NaiveEvent out = event(center == nullptr ? NaiveEvent::Kind::Line : NaiveEvent::Kind::Arc);
    out.from_mm = corrected(frame(from));
    out.nominal_mm = frame(to);
    out.at_mm = corrected(out.nominal_mm);
    if (center != nullptr) out.center_mm = corrected(frame(*center));
    out.turn = frame.is_mirror() ? -turn : turn;
    out.side = frame.is_mirror() ? -side : side;
    events_.push_back(out);
  }

  /// Plunge points as the tables of G45 to G50 give them, with sine 45 for their 0.707.
  void figure(const SmNode& node, const Frame& frame) {
    const Vector2d at = mm_of(node.place);
    const double cutter = mm_of(kSmTools_um.at(static_cast<std::size_t>(tool_ - 1)));
    const double r = mm_of(node.radius_um);
    const double k = r / 2 - cutter / 4;
    const double sine = std::sqrt(0.5);
    const Vector2d sides = mm_of(node.second);
    NaiveEvent out = event(NaiveEvent::Kind::Figure);
    Vector2d plunge = at;
    switch (node.number) {
      case 45:
        plunge += Vector2d(sine * k, (1 + sine) * k);
        out.radius_mm = r - cutter / 2;
        break;
      case 46:
        plunge += Vector2d(-sine * k, (1 + sine) * k);
        out.radius_mm = r - cutter / 2;
        break;
      case 47:
        plunge += Vector2d(-(r + cutter / 2), cutter / 2);
        out.radius_mm = r + cutter / 2;
        break;
      case 48:
        plunge += Vector2d(-(r + cutter / 2), -cutter / 2);
        out.radius_mm = r + cutter / 2;
        break;
      default:
        plunge += Vector2d(0, sides.y() / 4 - cutter / 4);
        for (const double x : {-1.0, 1.0}) {
          for (const double y : {-1.0, 1.0}) {
            const Vector2d corner =
                at + Vector2d(x * (sides.x() - cutter) / 2, y * (sides.y() - cutter) / 2);
            out.corners_mm.push_back(corrected(frame(corner)));
          }
        }
        break;
    }
    const bool is_clockwise = node.number % 2 == 0;
    out.turn = is_clockwise != frame.is_mirror() ? -1 : 1;
    out.nominal_mm = frame(at);
    out.center_mm = out.at_mm = corrected(out.nominal_mm);
    out.from_mm = corrected(frame(plunge));
    events_.push_back(out);
  }

  const BoardMap& board_;
  std::vector<NaiveEvent> events_;
  int tool_ = 0;
  std::optional<double> z_mm_;
  std::optional<double> k_mm_;
  bool depth_control_ = false;
  bool corrects_ = false;
  int n_groups_ = 0;
};

}  // namespace

std::vector<NaiveEvent> naive_events(const SmJob& job, const BoardMap& board) {
  Model model(board);
  model.run(job.nodes, {});
  return model.take();
}

}  // namespace panelcal::test
