// SPDX-License-Identifier: Apache-2.0
#include "machine/files/machine_files.h"

#include <cstdlib>
#include <fstream>

#include "calib/base/json/facts.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

namespace fs = std::filesystem;

using testing::Eq;
using testing::Optional;

/// A folder for a machine.toml and the files that it names.
class MachineFilesTest : public testing::Test {
 protected:
  MachineFilesTest() {
    std::string pattern = testing::TempDir() + "machine_files_test_XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
    fs::create_directory(folder_ / "pictures");
    for (const char* const name :
         {"camera.cal.json", "zoom.cal.json", "plate.toml", "other.json"}) {
      std::ofstream(folder_ / name) << name;
    }
  }
  ~MachineFilesTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  FileRegister register_of(const std::string& text, std::string_view except = {}) const {
    std::ofstream(folder_ / "machine.toml") << text;
    FileRegister files;
    add_machine_files(folder_ / "machine.toml", files, except);
    return files;
  }

  std::optional<std::string> use_of(const std::string& name, const FileRegister& files) const {
    return files.use_of(folder_ / name);
  }

  fs::path folder_;
};

TEST_F(MachineFilesTest, HasEveryFileThatAnyKeyNames) {
  const FileRegister files = register_of(
      "[camera]\ncalibration = \"camera.cal.json\"\n"
      "[[camera.zoom]]\nlevel = 3\ncalibration = \"zoom.cal.json\"\n"
      "[key]\nthat.is.new = [\"no file\", \"plate.toml\"]\n");
  EXPECT_THAT(use_of("machine.toml", files), Optional(Eq("the machine file")));
  EXPECT_THAT(use_of("camera.cal.json", files),
              Optional(Eq("[camera] calibration of machine.toml")));
  EXPECT_THAT(use_of("zoom.cal.json", files),
              Optional(Eq("[camera.zoom] calibration of machine.toml")));
  EXPECT_THAT(use_of("plate.toml", files), Optional(Eq("[key.that.is] new of machine.toml")));
  EXPECT_EQ(use_of("other.json", files), std::nullopt);
}

TEST_F(MachineFilesTest, HasTheLedgerAndTheCouponsStateBeforeTheyExist) {
  const FileRegister files = register_of("[ledger]\nfile = \"drill.ledger\"\n[coupon]\nrows = 3\n");
  EXPECT_THAT(use_of("drill.ledger", files), Optional(Eq("the ledger of machine.toml")));
  EXPECT_THAT(use_of("drill.ledger.lock", files),
              Optional(Eq("the lock of the ledger of machine.toml")));
  EXPECT_THAT(use_of("drill.ledger-journal", files),
              Optional(Eq("the journal of the ledger of machine.toml")));
  EXPECT_THAT(use_of("coupon.json", files), Optional(Eq("the coupon's state of machine.toml")));
}

TEST_F(MachineFilesTest, HasTheFoldersOfCameras) {
  const std::string folder = (folder_ / "pictures").string();
  const FileRegister files = register_of("[nightly]\ncamera = \"folder:" + folder + "\"\n");
  EXPECT_THAT(use_of("pictures/new.png", files),
              Optional(Eq("in [nightly] camera of machine.toml")));
}

TEST_F(MachineFilesTest, LeavesOutWhatThisProcessPutsInForce) {
  const std::string text =
      "[table]\ncalibration = \"other.json\"\n[camera]\ncalibration = \"camera.cal.json\"\n";
  EXPECT_EQ(use_of("other.json", register_of(text, "table.calibration")), std::nullopt);
  EXPECT_TRUE(use_of("camera.cal.json", register_of(text, "table.calibration")));
  EXPECT_TRUE(use_of("other.json", register_of(text)));
}

TEST_F(MachineFilesTest, ProtectsTheFilesOfAFileThatIsNoToml) {
  const FileRegister files =
      register_of("[camera\ncalibration = \"camera.cal.json\"\n= \"plate.toml\n");
  EXPECT_THAT(use_of("camera.cal.json", files), Optional(Eq("a file of machine.toml")));
  EXPECT_EQ(use_of("other.json", files), std::nullopt);
}

TEST_F(MachineFilesTest, HasTheRecordsOfNights) {
  const fs::path reports = folder_ / "reports";
  fs::create_directory(reports);
  for (const char* const name : {"2026-11-21.json",
                                 "2026-11-21-2.html",
                                 "2026-11-22.json",
                                 "2026-11-21-.json",
                                 "2026-11-21-job.html",
                                 "2026-11-21.txt",
                                 "export.json"}) {
    std::ofstream(reports / name) << name;
  }
  FileRegister files;
  add_night_records(reports, files, "2026-11-22");
  EXPECT_THAT(use_of("reports/2026-11-21.json", files), Optional(Eq("the record of a night")));
  EXPECT_TRUE(use_of("reports/2026-11-21-2.html", files));
  for (const char* const name : {"2026-11-22.json",
                                 "2026-11-21-.json",
                                 "2026-11-21-job.html",
                                 "2026-11-21.txt",
                                 "export.json"}) {
    EXPECT_EQ(use_of(std::string("reports/") + name, files), std::nullopt) << name;
  }
  add_night_records(folder_ / "none", files);
}

TEST_F(MachineFilesTest, TakesAJobsReportForNoRecordOfANight) {
  const auto is_record = [&](const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name) << content;
    return is_night_record(folder_ / name);
  };
  const std::string page = "<!DOCTYPE html>\n" + std::string(facts::kPageMark);
  EXPECT_TRUE(
      is_record("2026-11-21.html", page + "{\"facts\":\"night\",\"version\":1}\n</script>"));
  EXPECT_FALSE(is_record("2026-11-21.html", page + "{\"facts\":\"job\",\"version\":1}\n</script>"));
  // Headings as pages had them before.
  EXPECT_TRUE(
      is_record("2026-11-21.html", "<main>\n<h1>Night of <b>2026-11-21</b> on <b>a</b></h1>"));
  EXPECT_FALSE(
      is_record("2026-11-21.html", "<h1><b>job.exc</b> on a; measured from m.jsonl; x</h1>"));
  EXPECT_TRUE(is_record("2026-11-21.html", "<!DOCTYPE html>")) << "it may have been one";
  EXPECT_TRUE(is_record("2026-11-21.json", "{"));
  EXPECT_FALSE(is_record("job.html", "<h1>Night of <b>2026-11-21</b> on <b>a</b></h1>"));
}

TEST_F(MachineFilesTest, NeedsNoMachineFile) {
  FileRegister files;
  add_machine_files(folder_ / "none.toml", files);
  EXPECT_EQ(use_of("other.json", files), std::nullopt);
}

}  // namespace
}  // namespace panelcal
