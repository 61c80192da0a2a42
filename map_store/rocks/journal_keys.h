// Makes the keys of what the journal keeps (docs/journal.md). Numbers are big-endian, so that keys
// sort as they do; missions' names hold no zero byte.
#ifndef CORBSLAM_MAP_STORE_ROCKS_JOURNAL_KEYS_H_
#define CORBSLAM_MAP_STORE_ROCKS_JOURNAL_KEYS_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "slam/util/ids.h"

namespace corbslam::map_store {

enum class JournalPart : char {
  kFormat = 'F',
  kProgram = 'P',
  kMission = 'M',
  kRecord = 'R',
  kSnapshot = 'S',
  kFeatures = 'K',
  kPicture = 'I',
  kPictureOrder = 'J',
};

// Returns the prefix with which all of a mission's keys of that part begin.
std::string MissionPrefix(JournalPart part, std::string_view mission);
// Returns the first key behind all that begin with the prefix.
std::string EndOfPrefix(std::string prefix);

std::string FormatKey();
// Of the version of the program that had the guard open last.
std::string ProgramKey();
std::string MissionKey(std::string_view mission);
std::string RecordKey(std::string_view mission, uint64_t position);
std::string SnapshotKey(std::string_view mission, uint64_t position, uint32_t chunk);
std::string FeaturesKey(std::string_view mission, KeyframeId keyframe);
std::string PictureKey(std::string_view mission, KeyframeId keyframe);
// Under this stands which keyframe's picture came as the mission's `order`-th.
std::string PictureOrderKey(std::string_view mission, uint64_t order);

// These return the number at the end of a record's key, and the keyframe at the end of a key of
// features. Keys that are too short give 0 and an invalid id.
uint64_t PositionOf(std::string_view record_key);
KeyframeId KeyframeOf(std::string_view features_key);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_JOURNAL_KEYS_H_
