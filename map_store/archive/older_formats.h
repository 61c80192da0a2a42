// Says what becomes of data of formats that this program does not read any more.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_OLDER_FORMATS_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_OLDER_FORMATS_H_

namespace corbslam::map_store {

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

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_OLDER_FORMATS_H_
