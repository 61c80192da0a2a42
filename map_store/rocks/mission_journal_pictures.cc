// Implements the part of MissionJournal that keeps keyframes' pictures. Under a picture's key stand
// its place in the order in which pictures came, its scale, and the JPEG; under the order's key the
// keyframe and how many bytes the JPEG has, so that a journal is opened without reading pictures.
#include <rocksdb/write_batch.h>

#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_journal.h"
#include "map_store/rocks/rocks_database.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

void AppendNumber(uint64_t number, std::string* bytes) {
  for (int shift = 0; shift < 64; shift += 8) bytes->push_back(static_cast<char>(number >> shift));
}

// Takes a number off the front; there must be one.
uint64_t TakeNumber(std::string_view& bytes) {
  uint64_t number = 0;
  for (size_t i = 0; i < sizeof(uint64_t); ++i) {
    number |= static_cast<uint64_t>(static_cast<uint8_t>(bytes[i])) << (8 * i);
  }
  bytes.remove_prefix(sizeof(uint64_t));
  return number;
}

std::string EncodePicture(uint64_t order, const KeyframePicture& picture) {
  std::string bytes;
  AppendNumber(order, &bytes);
  AppendNumber(std::bit_cast<uint64_t>(picture.scale), &bytes);
  return bytes + picture.jpeg;
}

std::optional<KeyframePicture> DecodePicture(KeyframeId keyframe, std::string_view bytes) {
  if (bytes.size() < 2 * sizeof(uint64_t)) return std::nullopt;
  TakeNumber(bytes);
  KeyframePicture picture;
  picture.keyframe = keyframe;
  picture.scale = std::bit_cast<double>(TakeNumber(bytes));
  picture.jpeg = std::string(bytes);
  return picture;
}

std::string EncodeOrder(const BookedPicture& picture) {
  std::string bytes;
  AppendNumber(picture.keyframe.local_map.value, &bytes);
  AppendNumber(picture.keyframe.index, &bytes);
  AppendNumber(picture.bytes, &bytes);
  return bytes;
}

std::optional<BookedPicture> DecodeOrder(uint64_t order, std::string_view bytes) {
  if (bytes.size() != 3 * sizeof(uint64_t)) return std::nullopt;
  BookedPicture picture;
  picture.order = order;
  picture.keyframe.local_map.value = TakeNumber(bytes);
  picture.keyframe.index = static_cast<uint32_t>(TakeNumber(bytes));
  picture.bytes = TakeNumber(bytes);
  return picture;
}

}  // namespace

void MissionJournal::AddRemovals(const std::vector<BookedPicture>& gone,
                                 rocksdb::WriteBatch& batch) const {
  for (const BookedPicture& picture : gone) {
    batch.Delete(PictureKey(name_, picture.keyframe));
    batch.Delete(PictureOrderKey(name_, picture.order));
  }
}

absl::Status MissionJournal::PutPicture(const KeyframePicture& picture, uint64_t max_bytes) {
  RETURN_IF_ERROR(Damage());
  const uint64_t bytes = picture.jpeg.size();
  // Of a disk that fills up, maps have the last part.
  RETURN_IF_ERROR(CheckRoom(options_, options_.min_free_bytes + bytes));
  BookedPicture added;
  std::vector<BookedPicture> gone;
  {
    absl::MutexLock lock(&mutex_);
    if (bytes > max_bytes || pictures_.Has(picture.keyframe)) return absl::OkStatus();
    gone = pictures_.TakeBeyond(max_bytes - bytes);
    added = pictures_.Add(picture.keyframe, bytes, written_);
    may_be_wasteful_ |= !gone.empty();
  }
  rocksdb::WriteBatch batch;
  AddRemovals(gone, batch);
  batch.Put(PictureKey(name_, picture.keyframe), EncodePicture(added.order, picture));
  batch.Put(PictureOrderKey(name_, added.order), EncodeOrder(added));
  const absl::Status written = ToStatus(database_->Write(batch, false));
  if (written.ok()) return written;
  absl::MutexLock lock(&mutex_);
  pictures_.Take(picture.keyframe);
  for (const BookedPicture& oldest : gone) pictures_.Put(oldest);
  return written;
}

absl::StatusOr<KeyframePicture> MissionJournal::ReadPicture(KeyframeId keyframe) const {
  std::string bytes;
  const rocksdb::Status read = database_->Get(PictureKey(name_, keyframe), &bytes);
  if (!read.ok() && !read.IsNotFound()) return ToStatus(read);
  std::optional<KeyframePicture> picture;
  if (read.ok()) picture = DecodePicture(keyframe, bytes);
  if (picture.has_value()) return *std::move(picture);
  return absl::NotFoundError(absl::StrCat("keyframe ", ToString(keyframe), " has no picture"));
}

absl::Status MissionJournal::ForEachPicture(
    const std::function<absl::Status(const KeyframePicture& picture)>& visit) const {
  const std::string orders = MissionPrefix(JournalPart::kPictureOrder, name_);
  return database_->Scan(orders, EndOfPrefix(orders),
                         [&](std::string_view key, std::string_view value) -> absl::Status {
                           const auto booked = DecodeOrder(map_store::PositionOf(key), value);
                           if (!booked.has_value()) return absl::OkStatus();
                           const auto picture = ReadPicture(booked->keyframe);
                           if (absl::IsNotFound(picture.status())) return absl::OkStatus();
                           RETURN_IF_ERROR(picture.status());
                           return visit(*picture);
                         });
}

absl::Status MissionJournal::LoadPictures() {
  const std::string orders = MissionPrefix(JournalPart::kPictureOrder, name_);
  return database_->Scan(orders, EndOfPrefix(orders),
                         [&](std::string_view key, std::string_view value) {
                           auto booked = DecodeOrder(map_store::PositionOf(key), value);
                           if (!booked.has_value()) return absl::OkStatus();
                           absl::MutexLock lock(&mutex_);
                           booked->position = last_;
                           pictures_.Put(*booked);
                           return absl::OkStatus();
                         });
}

}  // namespace corbslam::map_store
