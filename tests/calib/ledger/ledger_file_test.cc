// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <fstream>

#include "calib/base/files/atomic_file.h"
#include "calib/ledger/ledger.h"
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/calib/ledger/drafts.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::first_night;
using test::offset_draft;
using test::spindle;
using testing::AnyOf;
using testing::ElementsAre;

constexpr std::size_t kPageBytes = 4096;

/// Another program at work on the file.
class Other {
 public:
  explicit Other(const std::filesystem::path& path) {
    sqlite3_open(path.c_str(), &handle_);
    run("PRAGMA synchronous=OFF");
  }
  Other(const Other&) = delete;
  Other& operator=(const Other&) = delete;
  ~Other() { sqlite3_close(handle_); }

  void run(const std::string& sql) {
    char* message = nullptr;
    sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, &message);
    EXPECT_EQ(message, nullptr) << message;
    sqlite3_free(message);
  }

 private:
  sqlite3* handle_ = nullptr;
};

class LedgerFileTest : public test::LedgerFolder {
 protected:
  /// A ledger of six entries, one of them large enough for pages of its own.
  LedgerHead filled() {
    Ledger ledger = opened();
    for (int i = 1; i <= 6; ++i) {
      LedgerDraft draft = offset_draft(i);
      if (i == 3) draft.result = '"' + std::string(10000, 'r') + '"';
      EXPECT_TRUE(ledger.append(draft));
    }
    return ledger.head().value();
  }
  Expected<Ledger> open() const { return Ledger::open(path(), first_night()); }
  /// Changes made behind the triggers' back.
  void tamper(const std::string& sql) {
    Other other(path());
    other.run(
        "PRAGMA writable_schema=ON;"
        "CREATE TEMP TABLE kept AS SELECT name, sql FROM sqlite_schema WHERE type='trigger';"
        "DROP TRIGGER ledger_entry_update; DROP TRIGGER ledger_entry_delete;"
        "DROP TRIGGER ledger_entry_insert;" +
        sql);
    for (const char* name : {"ledger_entry_update", "ledger_entry_delete", "ledger_entry_insert"}) {
      other.run(std::string("INSERT INTO sqlite_schema SELECT 'trigger', name, 'ledger_entry', 0, "
                            "sql FROM kept WHERE name='") +
                name + "'");
    }
  }
};

TEST_F(LedgerFileTest, StartsAloneUnderItsName) {
  ASSERT_TRUE(open());
  EXPECT_THAT(names(), ElementsAre("drill 1.ledger"));
  EXPECT_EQ(open()->head()->id, 0);
}

TEST_F(LedgerFileTest, MustBeThereToBeRead) {
  EXPECT_THAT(Ledger::open_to_read(path()), FailsWith(Code::FileUnreadable, "drill 1.ledger"));
  EXPECT_THAT(names(), ElementsAre());
  EXPECT_THAT(Ledger::open(folder_ / "no folder" / "a", first_night()),
              FailsWith(Code::DeviceWrite, "No such file"));
}

TEST_F(LedgerFileTest, OpenedToReadRecordsNothing) {
  const LedgerHead head = filled();
  Expected<Ledger> ledger = Ledger::open_to_read(path());
  ASSERT_TRUE(ledger) << ledger.error().text();
  EXPECT_EQ(ledger->verify().value(), head);
  EXPECT_THAT(ledger->append(offset_draft(1)), FailsWith(Code::DeviceWrite, "drill 1.ledger"));
  EXPECT_THAT(ledger->roll_back({spindle(1), 1, "off", "test", "test"}),
              FailsWith(Code::DeviceWrite, "drill 1.ledger"));
}

TEST_F(LedgerFileTest, LeavesOtherFilesAlone) {
  std::string text = "M48\nMETRIC,TZ\n";
  const auto expect_foreign = [&] {
    EXPECT_THAT(open(), FailsWith(Code::LedgerForeign));
    EXPECT_THAT(Ledger::open_to_read(path()), FailsWith(Code::LedgerForeign));
    EXPECT_THAT(Ledger::keep_aside(path(), first_night()), FailsWith(Code::LedgerForeign));
    EXPECT_THAT(names(), ElementsAre("drill 1.ledger"));
  };
  ASSERT_TRUE(write_file(path(), text));
  expect_foreign();
  EXPECT_EQ(read_file(path()).value(), text);

  text = R"({"panelcal":"ledger-entry","id":1,"time":"2026-11-21T08:37:38Z"})"
         "\n";
  ASSERT_TRUE(write_file(path(), text));
  expect_foreign();
  EXPECT_EQ(read_file(path()).value(), text);

  std::filesystem::remove(path());
  Other(path()).run("CREATE TABLE t(x); INSERT INTO t VALUES ('{\"panelcal\":\"ledger-entry\"')");
  expect_foreign();

  std::filesystem::remove(path());
  std::filesystem::create_directory(path());
  expect_foreign();
}

TEST_F(LedgerFileTest, RefusesNewerVersions) {
  filled();
  Other(path()).run("PRAGMA user_version=2");
  EXPECT_THAT(open(), FailsWith(Code::LedgerNewer, "version 2"));
  EXPECT_THAT(Ledger::keep_aside(path(), first_night()), FailsWith(Code::LedgerNewer));
}

TEST_F(LedgerFileTest, NoticesWhenANewerVersionTakesOver) {
  Ledger ledger = opened();
  Other(path()).run("PRAGMA user_version=2");
  EXPECT_THAT(ledger.append(offset_draft(1)), FailsWith(Code::LedgerNewer, "version 2"));
}

TEST_F(LedgerFileTest, KeepsDamagedOnesAsideUnderNewNames) {
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(write_file(path(), ""));
    EXPECT_THAT(open(), FailsWith(Code::LedgerCorrupt));
    const auto aside = Ledger::keep_aside(path(), first_night());
    ASSERT_TRUE(aside) << aside.error().text();
    EXPECT_TRUE(std::filesystem::exists(*aside));
  }
  ASSERT_TRUE(open());
  EXPECT_THAT(names(),
              ElementsAre("drill 1.ledger",
                          "drill 1.ledger.corrupt-20261121T083738Z",
                          "drill 1.ledger.corrupt-20261121T083738Z-2"));
  EXPECT_THAT(Ledger::keep_aside(path(), first_night()), FailsWith(Code::LedgerEntryInvalid));
  EXPECT_THAT(Ledger::keep_aside(folder_ / "none", first_night()), FailsWith(Code::FileUnreadable));
}

TEST_F(LedgerFileTest, KnowsALedgerWhoseStartIsGone) {
  filled();
  std::string bytes = read_file(path()).value();
  std::fill_n(bytes.begin(), kPageBytes, '\0');
  std::filesystem::remove(path());  // no output replaces a ledger
  ASSERT_TRUE(write_file(path(), bytes));
  EXPECT_THAT(open(), FailsWith(Code::LedgerCorrupt));
  const auto aside = Ledger::keep_aside(path(), first_night());
  ASSERT_TRUE(aside) << aside.error().text();
  EXPECT_EQ(read_file(*aside).value(), bytes);
}

/// Truth: what the sound ledger says. A flipped bit is found, or it stands where nothing counts.
TEST_F(LedgerFileTest, FindsFlippedBits) {
  const LedgerHead head = filled();
  const std::string sound = read_file(path()).value();
  const std::filesystem::path copy = folder_ / "copy";
  const std::string result = open()->result(3).value();
  constexpr std::size_t kStride = 331;
  int n_found = 0;
  int n_tried = 0;
  for (std::size_t i = 0; i < sound.size(); i += kStride) {
    std::string bytes = sound;
    bytes[i] = static_cast<char>(bytes[i] ^ (1 << (i % 8)));
    std::ofstream(copy, std::ios::binary) << bytes;
    ++n_tried;
    const Expected<Ledger> ledger = Ledger::open_to_read(copy, {.n_checked = 2});
    const Expected<LedgerHead> verified =
        ledger ? ledger->verify() : Expected<LedgerHead>(failure(ledger.error()));
    if (!verified) {
      ++n_found;
      EXPECT_THAT(verified.error().code,
                  AnyOf(Code::LedgerCorrupt, Code::LedgerNewer, Code::FileUnreadable))
          << "byte " << i << ": " << verified.error().text();
    } else {
      EXPECT_EQ(*verified, head) << "byte " << i;
      EXPECT_EQ(ledger->result(3).value(), result) << "byte " << i;
    }
  }
  // The text of the entries and results is most of the file.
  EXPECT_GT(n_found, n_tried / 2) << "of " << n_tried;
}

TEST_F(LedgerFileTest, FindsMissingEnds) {
  filled();
  const std::string sound = read_file(path()).value();
  // Less than a page does not say whose it was.
  for (std::size_t n = kPageBytes; n < sound.size(); n += kPageBytes / 2) {
    std::filesystem::remove(path());
    ASSERT_TRUE(write_file(path(), sound.substr(0, n)));
    EXPECT_THAT(open(), FailsWith(Code::LedgerCorrupt)) << n << " bytes";
  }
}

TEST_F(LedgerFileTest, FindsChangesMadeByOthers) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"UPDATE ledger_entry SET content = replace(content, '21.25', '21.75') WHERE id = 2",
       "entry 2"},
      {"UPDATE ledger_entry SET result = 'null' WHERE id = 3", "entry 3"},
      {"DELETE FROM ledger_entry WHERE id = 4", "5 of 6 entries"},
      {"UPDATE ledger_entry SET id = id + 10 WHERE id = 1", "6 of 11 entries"},
      {"UPDATE ledger_entry SET hash = previous WHERE id = 6", "entry 6"},
      {"UPDATE ledger_entry SET previous = hash WHERE id = 5", "entry 5"},
  };
  filled();
  const std::string sound = read_file(path()).value();
  for (const auto& [sql, part] : cases) {
    std::ofstream(path(), std::ios::binary) << sound;
    tamper(sql);
    EXPECT_THAT(open(), FailsWith(Code::LedgerCorrupt, part)) << sql;
    // Without the check at opening, `verify` finds it.
    const Expected<Ledger> ledger = Ledger::open_to_read(path(), {.n_checked = 0});
    const auto verified = ledger ? ledger->verify() : tl::unexpected(ledger.error());
    EXPECT_THAT(verified, FailsWith(Code::LedgerCorrupt)) << sql;
    EXPECT_TRUE(Ledger::keep_aside(path(), first_night())) << sql;
  }
}

TEST_F(LedgerFileTest, ALostEndShowsAgainstANotedHead) {
  const LedgerHead head = filled();
  tamper("DELETE FROM ledger_entry WHERE id = 6");
  const Expected<Ledger> ledger = open();
  ASSERT_TRUE(ledger) << ledger.error().text();
  EXPECT_NE(ledger->verify().value(), head);
}

TEST_F(LedgerFileTest, FindsMissingTriggers) {
  filled();
  Other(path()).run("DROP TRIGGER ledger_entry_delete");
  EXPECT_THAT(open(), FailsWith(Code::LedgerCorrupt));
}

TEST_F(LedgerFileTest, OtherToolsCanOnlyAdd) {
  filled();
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open(path().c_str(), &handle), SQLITE_OK);
  for (const char* sql :
       {"UPDATE ledger_entry SET result = ''",
        "DELETE FROM ledger_entry",
        "INSERT OR REPLACE INTO ledger_entry(id, previous, hash, content, result) "
        "VALUES (2, '', '', '{}', '')",
        "INSERT INTO ledger_entry(id, previous, hash, content, result) "
        "VALUES (9, '', '', '{}', '')"}) {
    EXPECT_EQ(sqlite3_exec(handle, sql, nullptr, nullptr, nullptr), SQLITE_CONSTRAINT) << sql;
  }
  sqlite3_close(handle);
  EXPECT_TRUE(open()->verify());
}

TEST_F(LedgerFileTest, AddsNothingToADamagedEnd) {
  filled();
  Ledger ledger = opened();
  tamper("UPDATE ledger_entry SET content = replace(content, '21.25', '21.75') WHERE id = 6");
  EXPECT_THAT(ledger.append(offset_draft(7)), FailsWith(Code::LedgerCorrupt, "entry 6"));
  EXPECT_THAT(ledger.entry(6), FailsWith(Code::LedgerCorrupt, "entry 6"));
}

TEST_F(LedgerFileTest, RecordsNothingInAFileThatWasMoved) {
  Ledger ledger = opened();
  std::filesystem::rename(path(), folder_ / "elsewhere");
  EXPECT_THAT(ledger.append(offset_draft(1)), FailsWith(Code::DeviceWrite));
  ASSERT_TRUE(open());
  EXPECT_THAT(ledger.append(offset_draft(1)), FailsWith(Code::DeviceWrite));
}

TEST_F(LedgerFileTest, SaysWhenItIsBusy) {
  Ledger first = opened();
  LedgerOptions impatient;
  impatient.busy_timeout = std::chrono::milliseconds(20);
  Expected<Ledger> second = Ledger::open(path(), first_night(), impatient);
  ASSERT_TRUE(second);
  Other other(path());
  other.run("BEGIN EXCLUSIVE");
  EXPECT_THAT(second->append(offset_draft(1)), FailsWith(Code::LedgerBusy));
  EXPECT_THAT(Ledger::open(path(), first_night(), impatient), FailsWith(Code::LedgerBusy));
  other.run("ROLLBACK");
  ASSERT_TRUE(second->append(offset_draft(1)));
  ASSERT_TRUE(first.append(offset_draft(2)));
  EXPECT_EQ(second->head()->id, 2);
}

TEST_F(LedgerFileTest, UndoesAnInterruptedWriteAlsoToRead) {
  const LedgerHead head = filled();
  const std::filesystem::path copy = folder_ / "copy";
  const std::filesystem::path other_copy = folder_ / "other copy";
  {
    // State that a power cut leaves: pages of an entry in the file, and the journal that undoes
    // them.
    Other other(path());
    other.run(
        "PRAGMA cache_size=1; PRAGMA cache_spill=1; BEGIN IMMEDIATE;"
        "INSERT INTO ledger_entry(id, previous, hash, content, result) "
        "VALUES (7, '', '', '{}', hex(zeroblob(200000)));");
    std::filesystem::copy_file(path(), copy);
    std::filesystem::copy_file(path().string() + "-journal", copy.string() + "-journal");
    std::filesystem::copy_file(path(), other_copy);
    std::filesystem::copy_file(path().string() + "-journal", other_copy.string() + "-journal");
  }
  ASSERT_NE(std::filesystem::file_size(copy), std::filesystem::file_size(path()));
  const Expected<Ledger> read = Ledger::open_to_read(other_copy);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->verify().value(), head);
  const Expected<Ledger> ledger = Ledger::open(copy, first_night());
  ASSERT_TRUE(ledger) << ledger.error().text();
  EXPECT_EQ(ledger->verify().value(), head);
}

/// In a process of its own, since the limit cannot be raised again for what is written meanwhile.
TEST_F(LedgerFileTest, RecordsNothingOnceFilesCannotGrow) {
  const LedgerHead head = filled();
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    Expected<Ledger> ledger = open();
    const rlim_t now = std::filesystem::file_size(path()) + 2 * kPageBytes;
    const rlimit limit{now, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    LedgerDraft draft = offset_draft(7);
    draft.result = '"' + std::string(100000, 'r') + '"';
    const Expected<LedgerEntry> entry = ledger->append(draft);
    const bool said = !entry && entry.error().code == Code::DeviceWrite;
    ::_exit(said && ledger->head().value() == head ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(open()->verify().value(), head);
  EXPECT_TRUE(open()->append(offset_draft(7)));
}

}  // namespace
}  // namespace panelcal
