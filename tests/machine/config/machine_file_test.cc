// SPDX-License-Identifier: Apache-2.0
#include "machine/config/machine_file.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

TEST(MachineFile, HasEachKeyOnceWithAMeaning) {
  std::set<std::string> seen;
  const FileDescription file = machine_file();
  for (const TableDescription* const table : file.tables) {
    for (const Field& field : table->fields) {
      const std::string key = table->heading() + " " + std::string(field.key);
      EXPECT_TRUE(seen.insert(key).second) << key << " is there twice";
      EXPECT_FALSE(field.meaning.empty()) << key;
    }
  }
  EXPECT_GT(seen.size(), 250U);
}

}  // namespace
}  // namespace panelcal::internal
