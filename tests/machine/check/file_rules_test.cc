// SPDX-License-Identifier: Apache-2.0
#include "machine/check/file_rules.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "machine/config/machine_config.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

namespace fs = std::filesystem;

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A folder with the machine.toml of a machine that probes its table at night.
class FileRulesTest : public testing::Test {
 protected:
  FileRulesTest() {
    std::string pattern = testing::TempDir() + "file_rules_test_XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
    fs::create_directories(folder_ / "pictures");
    fs::create_directories(folder_ / "list");
    put("pictures/a.png", "");
    put("list/images.csv", "");
    put("list/a.png", "");
    put("temperature.txt", "21");
    put("notes.txt", "mine");
  }
  ~FileRulesTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  void put(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
  }

  /// Problems of a machine.toml whose map or reports, in line 12 or 9, are these.
  std::vector<std::string> problems(const std::string& map_file,
                                    const std::string& reports = "reports") const {
    const std::string text =
        "[coupon]\norigin_mm = [0, 0]\nstate = \"rows.json\"\n[ledger]\nfile = \"drill.ledger\"\n"
        "[nightly]\ncamera = \"folder:" +
        (folder_ / "pictures").string() + "\"\ncalibrate = [\"surface\"]\nreports = \"" + reports +
        "\"\ntemperature_file = \"temperature.txt\"\n[nightly.surface]\nfile = \"" + map_file +
        "\"\nlow_mm = [0, 0]\nhigh_mm = [9, 9]\ncolumns = 4\nrows = 4\n";
    const fs::path file = folder_ / "machine.toml";
    std::ofstream(file) << text;
    const auto config = read_machine_config(file);
    if (!config) return {config.error().text()};
    DiagnosticLog log;
    check_file_rules(*config, StatedKeys::of_file(file), log);
    std::vector<std::string> texts;
    for (const Diagnostic& diagnostic : log.kept()) {
      EXPECT_EQ(diagnostic.place.file, file.string());
      texts.push_back(std::to_string(diagnostic.place.line) + ": " + diagnostic.text());
    }
    return texts;
  }

  fs::path folder_;
};

TEST_F(FileRulesTest, AMapHasItsOwnFile) {
  EXPECT_THAT(problems("surface.json"), IsEmpty());
  for (const std::string name : {"machine.toml",
                                 "drill.ledger",
                                 "drill.ledger.lock",
                                 "rows.json",
                                 "temperature.txt",
                                 "./temperature.txt",
                                 "pictures/a.png",
                                 "pictures/new.json",
                                 "list/a.png"}) {
    EXPECT_THAT(problems(name),
                ElementsAre(testing::AllOf(testing::StartsWith("12: "),
                                           HasSubstr("error[config-value]"),
                                           HasSubstr("[nightly.surface]"))))
        << name;
  }
}

TEST_F(FileRulesTest, NoFileOfAnotherKindIsReplacedByAMap) {
  EXPECT_THAT(problems("notes.txt"), ElementsAre(HasSubstr("\"notes.txt\", which is not the map")));
}

TEST_F(FileRulesTest, ReportsHaveTheirOwnFolder) {
  fs::create_directory(folder_ / "reports");
  EXPECT_THAT(problems("surface.json"), IsEmpty());
  for (const std::string name : {"drill.ledger", "notes.txt", "pictures", "list"}) {
    EXPECT_THAT(problems("surface.json", name),
                ElementsAre(testing::AllOf(testing::StartsWith("9: "),
                                           HasSubstr("error[config-value]"),
                                           HasSubstr("reports in [nightly]"))))
        << name;
  }
}

}  // namespace
}  // namespace panelcal
