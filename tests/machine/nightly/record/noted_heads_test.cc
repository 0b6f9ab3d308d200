// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/noted_heads.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/base/json/facts.h"
#include "machine/nightly/record/night_history.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using internal::NotedHead;
using test::FailsWith;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string kHash(64, 'b');

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "panelcal-XXXXXX").string();
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    path_ = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

TEST(HeadIn, FindsItInEveryFileThatNotesOne) {
  const NotedHead head = {NotedHead::Use::Head, 12, kHash};
  EXPECT_EQ(head_in("\n {\"ledger\": {\"head\": 12, \"hash\": \"" + kHash + "\"}}"), head);
  EXPECT_EQ(head_in("{\"ledger_head\": {\"id\": 12, \"hash\": \"" + kHash + "\"}}"), head);
  EXPECT_EQ(head_in("<!DOCTYPE html>\n<dl>\n<dt>ledger head</dt><dd class=\"mono\">12 " + kHash +
                    "</dd>\n"),
            head);
  EXPECT_EQ(head_in("<!DOCTYPE html>\n" + std::string(facts::kPageMark) +
                    "{\"facts\":\"night\",\"ledger_head\":{\"id\":12,\"hash\":\"" + kHash +
                    "\"}}\n</script>\n"),
            head);
}

TEST(HeadIn, TakesNothingElseForOne) {
  for (const std::string& text :
       {std::string(),
        std::string("{"),
        std::string("[]"),
        std::string("{\"ledger\": 4}"),
        std::string("{\"ledger_head\": {\"id\": 0, \"hash\": \"\"}}"),
        std::string("{\"ledger_head\": {\"id\": \"12\"}}"),
        "<dt>ledger</dt><dd class=\"mono\">12 " + kHash + "</dd>",
        std::string("<dt>ledger head</dt><dd class=\"mono\">not known: 12</dd>"),
        // A text inside of facts is no row of a page.
        std::string(facts::kPageMark) +
            "{\"notes\":[\"<dt>ledger head</dt><dd class=\\\"mono\\\">12 " + kHash + "</dd>\"]}",
        std::string("<dt>ledger head</dt><dd class=\"mono\">12")}) {
    EXPECT_EQ(head_in(text), std::nullopt) << text;
  }
}

class NotedHeads : public ::testing::Test {
 protected:
  NotedHeads()
      : ledger_(*Ledger::open(folder_.path() / "a.ledger",
                              fixed_clock(*from_iso_8601("2026-11-21T02:00:00Z")))) {}

  LedgerEntry append(const std::string& result) {
    LedgerDraft draft;
    draft.record.key = {"drill 1", LedgerKind::Camera, "camera"};
    draft.record.asked_by = "timer";
    draft.record.software = "test";
    draft.result = result;
    return ledger_.append(draft).value();
  }
  std::vector<std::string> missing(const NotedHead& head, const std::string& bytes = "") const {
    return missing_entries(ledger_, {{"a.json", head, sha256(bytes)}}).value();
  }

  Folder folder_;
  Ledger ledger_;
};

TEST_F(NotedHeads, OfTheLedgerAreThere) {
  EXPECT_THAT(missing({NotedHead::Use::Head, 0, ""}), IsEmpty());
  const LedgerEntry first = append("{\"a\": 1}");
  const LedgerEntry second = append("{\"a\": 2}");
  EXPECT_THAT(missing({NotedHead::Use::Head, 2, second.hash}), IsEmpty());
  EXPECT_THAT(missing({NotedHead::Use::RecordedAfter, 1, first.hash}, "{\"a\": 2}"), IsEmpty());
}

TEST_F(NotedHeads, BeyondTheNewestEntryAreMissing) {
  append("{\"a\": 1}");
  EXPECT_THAT(missing({NotedHead::Use::Head, 2, kHash}),
              ElementsAre("\"a.json\" notes entry 2, and the newest is 1"));
}

TEST_F(NotedHeads, OfARewrittenEntryAreMissing) {
  append("{\"a\": 1}");
  EXPECT_THAT(missing({NotedHead::Use::Head, 1, kHash}),
              ElementsAre(HasSubstr("entry 1 with the hash bbbbbbbbbbbb...")));
}

/// The newest entry was deleted, and the calibration that it had put in force was not.
TEST_F(NotedHeads, OfACalibrationWithoutItsEntryAreMissing) {
  const LedgerEntry first = append("{\"a\": 1}");
  EXPECT_THAT(missing({NotedHead::Use::RecordedAfter, 1, first.hash}, "{\"a\": 2}"),
              ElementsAre("\"a.json\" was recorded after entry 1, and is no entry's result"));
  // An entry of before is not the one that it was recorded as.
  EXPECT_THAT(missing({NotedHead::Use::RecordedAfter, 1, first.hash}, "{\"a\": 1}"),
              testing::SizeIs(1));
}

/// A damaged ledger was kept aside: what its machine's files noted then is of no ledger that is
/// used.
TEST_F(NotedHeads, OfALedgerThatWasDamagedAreGivenUp) {
  const RecordWords words = {
      .date = *from_iso_8601("2026-11-21T02:00:00Z"), .asked_by = "timer", .software = "test"};
  ASSERT_TRUE(ledger_.append(begun_anew_draft("drill 1", "old.ledger", words, {kHash})));
  EXPECT_THAT(missing({NotedHead::Use::Head, 9, kHash}), IsEmpty());
  EXPECT_THAT(missing({NotedHead::Use::RecordedAfter, 1, kHash}), IsEmpty());
  EXPECT_THAT(missing({NotedHead::Use::Head, 9, std::string(64, 'c')}), testing::SizeIs(1));
}

TEST_F(NotedHeads, AreLookedForInWhatMachineTomlNames) {
  NightFiles files;
  files.ledger = folder_.path() / "a.ledger";
  files.spindle = folder_.path() / "spindle.cal.json";
  files.reports = folder_.path() / "reports";
  EXPECT_TRUE(check_noted_heads(files, &ledger_)) << "files that are not there yet note nothing";
  const LedgerEntry entry = append("{\"a\": 1}");
  const std::string note =
      "{\"ledger\": {\"recorded_after\": 1, \"hash\": \"" + entry.hash + "\"}}";
  ASSERT_TRUE(write_file(files.spindle, note));
  EXPECT_TRUE(check_noted_heads(files, &ledger_)) << "whether a person made it is asked elsewhere";
  EXPECT_THAT(check_noted_heads(files, nullptr),
              FailsWith(Code::LedgerCutOff, "notes entry 1, and there is no ledger"));
  std::filesystem::create_directories(files.reports);
  ASSERT_TRUE(write_file(files.reports / "2026-11-21.json",
                         "{\"ledger_head\": {\"id\": 2, \"hash\": \"" + kHash + "\"}}"));
  EXPECT_THAT(check_noted_heads(files, &ledger_),
              FailsWith(Code::LedgerCutOff, "notes entry 2, and the newest is 1"));
  EXPECT_THAT(noted_hashes(files).value(), testing::UnorderedElementsAre(entry.hash, kHash));
}

TEST_F(NotedHeads, OfACameraOfAnotherMachineAskForItsFileAlone) {
  NightFiles files;
  files.ledger = folder_.path() / "a.ledger";
  files.camera = folder_.path() / "camera.cal.json";
  files.table = folder_.path() / "table.cal.json";
  files.spindle = folder_.path() / "spindle.cal.json";
  const LedgerEntry entry = append("{\"a\": 1}");
  const auto note = [](const std::filesystem::path& file, int id, const std::string& hash) {
    ASSERT_TRUE(write_file(
        file, fmt::format("{{\"ledger\": {{\"head\": {}, \"hash\": \"{}\"}}}}", id, hash)));
  };
  note(files.camera, 1, kHash);
  note(files.table, 1, entry.hash);
  const auto remedy = [&](const Ledger* ledger) {
    const auto held = check_noted_heads(files, ledger);
    return held ? "not held" : held.error().expected;
  };
  EXPECT_THAT(remedy(&ledger_), AllOf(HasSubstr("camera.cal.json"), Not(HasSubstr("table.cal"))));
  EXPECT_THAT(remedy(&ledger_), Not(HasSubstr("coupon")));
  EXPECT_THAT(remedy(nullptr), AllOf(HasSubstr("camera.cal.json\" and from"), HasSubstr("table")));
  // The spindle's calibration is as old as the coupon's holes: the ledger may be an older copy.
  note(files.spindle, 2, kHash);
  EXPECT_THAT(remedy(&ledger_), HasSubstr("new coupon"));
}

TEST(FilesBelow, AreThoseOfFoldersInTheOrderOfTheirNames) {
  const Folder folder;
  std::filesystem::create_directory(folder.path() / "reports");
  for (const char* const name :
       {"reports/b.html", "reports/a.json", "reports/a.txt", "z.cal.json"}) {
    ASSERT_TRUE(write_file(folder.path() / name, "x"));
  }
  EXPECT_THAT(files_below({folder.path() / "z.cal.json", folder.path() / "reports"}).value(),
              ElementsAre(folder.path() / "z.cal.json",
                          folder.path() / "reports/a.json",
                          folder.path() / "reports/b.html"));
  EXPECT_THAT(files_below({folder.path() / "none"}), FailsWith(Code::FileUnreadable, "none"));
}

}  // namespace
}  // namespace panelcal
