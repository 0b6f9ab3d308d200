// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include "program/model/operation.h"
#include "program/writers/pattern_copies.h"

namespace panelcal {

/// Operations of one pattern that are kept beyond the calls that passed them. Places of copies are
/// known only at PatternEnd; a language that writes the first one in place has to wait for it.
class StoredOperations {
 public:
  void add(const Operation& operation);
  void clear() { operations_.clear(); }
  std::size_t size() const { return operations_.size(); }
  const Operation& operator[](std::size_t i) const { return operations_[i].operation; }

 private:
  struct Stored {
    Operation operation;
    std::string text;  ///< of messages, settings and functions
    std::string file;
    std::vector<int> path;
    std::vector<Position<frame::Nominal>> targets;
    std::vector<Placement> copies;
  };
  std::deque<Stored> operations_;  ///< never moved: operations view into their own entry
};

/// The operation as a copy has it: places carried by `map`, senses and sides turned round by a
/// mirror. Targets and copies go into `targets` and `copies`, which the result views.
Operation carried(const Operation& operation,
                  const WorkMap& map,
                  std::vector<Position<frame::Nominal>>& targets,
                  std::vector<Placement>& copies);

}  // namespace panelcal
