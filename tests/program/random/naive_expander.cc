// SPDX-License-Identifier: Apache-2.0
#include "tests/program/random/naive_expander.h"

#include <cmath>
#include <optional>
#include <sstream>

namespace panelcal::test {
namespace {

using Lines = std::vector<std::string>;
using Holes = std::vector<Steps>;

struct Head {
  Steps at;
  bool incremental = false;
};

/// The number behind `letter`, in steps; a letter alone is zero.
std::optional<long> steps_behind(const std::string& line, char letter) {
  const auto at = line.find(letter);
  if (at == std::string::npos) return std::nullopt;
  const std::string rest = line.substr(at + 1);
  if (rest.empty() || (std::isalpha(static_cast<unsigned char>(rest[0])) != 0)) return 0;
  return std::lround(std::stod(rest) * 10000);
}

bool contains(const std::string& line, const char* code) {
  return line.find(code) != std::string::npos;
}

void run_plain_line(const std::string& line, Head& head, Holes& holes) {
  if (line == "G90") head.incremental = false;
  if (line == "G91") head.incremental = true;
  if (line.empty()) return;
  const long x = steps_behind(line, 'X').value_or(0);
  const long y = steps_behind(line, 'Y').value_or(0);
  if (line[0] == 'R') {
    for (int i = std::stoi(line.substr(1)); i > 0; --i) {
      head.at = {head.at.x + x, head.at.y + y};
      holes.push_back(head.at);
    }
  } else if (line[0] == 'X' || line[0] == 'Y') {
    if (head.incremental) {
      head.at = {head.at.x + x, head.at.y + y};
    } else {
      if (contains(line, "X")) head.at.x = x;
      if (contains(line, "Y")) head.at.y = y;
    }
    holes.push_back(head.at);
  }
}

Steps copied(Steps hole, const std::string& line, Steps offset) {
  if (contains(line, "M80")) hole.x = -hole.x;
  if (contains(line, "M90")) hole.y = -hole.y;
  if (contains(line, "M70")) std::swap(hole.x, hole.y);
  return {hole.x + offset.x, hole.y + offset.y};
}

/// Everything from behind the first M01 to the M08; `made` is what the pattern made.
Holes copies_of(Holes made, const Lines& lines, std::size_t& i) {
  Holes all = made;
  Steps offset;
  for (; lines[i] != "M08"; ++i) {
    const std::string& line = lines[i];
    if (line == "M01") {
      made = all;
      offset = {};
    } else if (line == "M02") {
      offset = {};
    } else {
      for (int n = line[0] == 'R' ? std::stoi(line.substr(1)) : 1; n > 0; --n) {
        offset.x += steps_behind(line, 'X').value_or(0);
        offset.y += steps_behind(line, 'Y').value_or(0);
        for (const Steps& hole : made) all.push_back(copied(hole, line, offset));
      }
    }
  }
  return all;
}

}  // namespace

std::vector<Steps> naive_holes(const std::string& body) {
  Lines lines;
  std::istringstream stream(body);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);

  Holes holes;
  Head head;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i] != "M25") {
      run_plain_line(lines[i], head, holes);
      continue;
    }
    Holes pattern;
    for (++i; lines[i] != "M01"; ++i) run_plain_line(lines[i], head, pattern);
    const Holes all = copies_of(pattern, lines, ++i);
    holes.insert(holes.end(), all.begin(), all.end());
    head.at = {};
  }
  return holes;
}

}  // namespace panelcal::test
