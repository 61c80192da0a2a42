#include "map_store/rocks/journal_keys.h"

#include <concepts>
#include <cstddef>

namespace corbslam::map_store {
namespace {

template <std::unsigned_integral T>
void AppendBigEndian(T number, std::string* key) {
  for (size_t i = sizeof(T); i-- > 0;) key->push_back(static_cast<char>(number >> (8 * i)));
}

template <std::unsigned_integral T>
T ReadBigEndian(std::string_view bytes) {
  T number = 0;
  for (const char byte : bytes.substr(0, sizeof(T))) {
    number = static_cast<T>(number << 8) | static_cast<uint8_t>(byte);
  }
  return number;
}

}  // namespace

std::string MissionPrefix(JournalPart part, std::string_view mission) {
  std::string key(1, static_cast<char>(part));
  key.append(mission);
  key.push_back('\0');
  return key;
}

std::string EndOfPrefix(std::string prefix) {
  prefix.back() = static_cast<char>(prefix.back() + 1);  // The prefix's zero byte becomes 1.
  return prefix;
}

std::string FormatKey() { return std::string(1, static_cast<char>(JournalPart::kFormat)); }

std::string ProgramKey() { return std::string(1, static_cast<char>(JournalPart::kProgram)); }

std::string MissionKey(std::string_view mission) {
  return MissionPrefix(JournalPart::kMission, mission);
}

std::string RecordKey(std::string_view mission, uint64_t position) {
  std::string key = MissionPrefix(JournalPart::kRecord, mission);
  AppendBigEndian(position, &key);
  return key;
}

std::string SnapshotKey(std::string_view mission, uint64_t position, uint32_t chunk) {
  std::string key = MissionPrefix(JournalPart::kSnapshot, mission);
  AppendBigEndian(position, &key);
  AppendBigEndian(chunk, &key);
  return key;
}

std::string FeaturesKey(std::string_view mission, KeyframeId keyframe) {
  std::string key = MissionPrefix(JournalPart::kFeatures, mission);
  AppendBigEndian(keyframe.local_map.value, &key);
  AppendBigEndian(keyframe.index, &key);
  return key;
}

std::string PictureKey(std::string_view mission, KeyframeId keyframe) {
  std::string key = MissionPrefix(JournalPart::kPicture, mission);
  AppendBigEndian(keyframe.local_map.value, &key);
  AppendBigEndian(keyframe.index, &key);
  return key;
}

std::string PictureOrderKey(std::string_view mission, uint64_t order) {
  std::string key = MissionPrefix(JournalPart::kPictureOrder, mission);
  AppendBigEndian(order, &key);
  return key;
}

uint64_t PositionOf(std::string_view record_key) {
  constexpr size_t kSize = sizeof(uint64_t);
  if (record_key.size() < kSize) return 0;
  return ReadBigEndian<uint64_t>(record_key.substr(record_key.size() - kSize));
}

KeyframeId KeyframeOf(std::string_view features_key) {
  constexpr size_t kSize = sizeof(uint64_t) + sizeof(uint32_t);
  if (features_key.size() < kSize) return {};
  const std::string_view id = features_key.substr(features_key.size() - kSize);
  return {{ReadBigEndian<uint64_t>(id)}, ReadBigEndian<uint32_t>(id.substr(sizeof(uint64_t)))};
}

}  // namespace corbslam::map_store
