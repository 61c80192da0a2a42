#include "map_store/rocks/backup_note.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

TEST(BackupNoteTest, IsReadAsItWasWrittenAndPassesOverWhatIsNewer) {
  BackupNote note;
  note.facts = {absl::FromUnixNanos(1'700'000'000'123'456'789), 7, 4711, true, "0123"};
  note.mark = {"a-b=c", 99};
  note.format = 11;
  note.program = "0.1.0";
  const auto read = DecodeBackupNote(Encode(note) + "colour=blue\n");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->facts.created, note.facts.created);
  EXPECT_EQ(read->facts.revision, 7u);
  EXPECT_EQ(read->facts.keyframes, 4711u);
  EXPECT_TRUE(read->facts.archived);
  EXPECT_EQ(read->facts.mission_uid, "0123");
  EXPECT_EQ(read->mark, note.mark);
  EXPECT_EQ(read->format, 11u);
  EXPECT_EQ(read->program, "0.1.0");
}

TEST(BackupNoteTest, ANoteThatIsNoneIsRefused) {
  for (const char* text : {"", "created_ns=x", "\n\n=\n", "revision=3\nkeyframes=1\n"}) {
    EXPECT_TRUE(absl::IsDataLoss(DecodeBackupNote(text).status())) << text;
  }
}

}  // namespace
}  // namespace corbslam::map_store
