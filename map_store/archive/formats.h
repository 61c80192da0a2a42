// Numbers the formats of what is on the disk, and says what becomes of those that this program does
// not read any more (docs/upgrade.md). Who writes something that the program before can't read
// raises the numbers of the journal and of backups.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_FORMATS_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_FORMATS_H_

#include <cstdint>

namespace corbslam::map_store {

// Of the whole journal. The one before is read and becomes kJournalFormat when it is opened; others
// are refused. In format 15 nobody knows whose a deleted local map was.
inline constexpr uint32_t kOldestJournalFormat = 15;
inline constexpr uint32_t kJournalFormat = 16;

// Of files of `mission backup`. Format 12 holds states of format 10; otherwise it is the same.
inline constexpr uint32_t kOldestBackupFormat = 12;
inline constexpr uint32_t kBackupFormat = 13;

// Of a mission's state, in both. In format 10 nobody knows whose a deleted local map was.
inline constexpr uint32_t kOldestStateFormat = 10;
inline constexpr uint32_t kFirstStateWithNumbers = 11;
inline constexpr uint32_t kStateFormat = 11;

// Programs of commit f5f37d9e read journals of formats 5 to 16 and files of backups of formats 4 to
// 13, and back up in the newest.
inline constexpr char kHowToReadOlder[] =
    ": start map_store of commit f5f37d9e with it, which reads it, write each mission to a file "
    "with that commit's `corbslam mission backup`, and restore the file here (docs/upgrade.md)";
// The same, of a file of `mission backup`.
inline constexpr char kHowToReadOlderBackup[] =
    ": restore it into a map_store of commit f5f37d9e, back the mission up there with that "
    "commit's "
    "`corbslam mission backup`, and restore that file here (docs/upgrade.md)";

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_FORMATS_H_
