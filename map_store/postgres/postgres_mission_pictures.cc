// Implements the part of PostgresMission that keeps keyframes' pictures.
#include <bit>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/postgres/pieces.h"
#include "map_store/postgres/postgres_mission.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

uint64_t PictureChecksum(std::string_view jpeg, uint64_t order) {
  return ChecksumOf(Piece{0, 1, 0, jpeg}, order);
}

}  // namespace

void PostgresMission::AddPictureRemovals(const std::vector<BookedPicture>& gone,
                                         SqlStatements& statements) const {
  for (const BookedPicture& picture : gone) {
    statements.push_back(
        {"DELETE FROM corbslam.pictures WHERE mission_id = $1 AND local_map = $2 AND keyframe = $3",
         {Id(), SqlValue::Bits(picture.keyframe.local_map.value),
          SqlValue::Number(picture.keyframe.index)}});
  }
}

absl::Status PostgresMission::PutPicture(const KeyframePicture& picture, uint64_t max_bytes) {
  RETURN_IF_ERROR(EnsureLoaded());
  // Pictures that go with waiting records must not go after this one has come.
  RETURN_IF_ERROR(FlushAll());
  const uint64_t bytes = picture.jpeg.size();
  BookedPicture added;
  std::vector<BookedPicture> gone;
  int64_t epoch = 0;
  {
    absl::MutexLock lock(&mutex_);
    RETURN_IF_ERROR(CheckOpen());
    if (bytes > max_bytes || pictures_.Has(picture.keyframe)) return absl::OkStatus();
    gone = pictures_.TakeBeyond(max_bytes - bytes);
    added = pictures_.Add(picture.keyframe, bytes, last_);
    epoch = epoch_;
  }
  SqlStatements statements;
  AddPictureRemovals(gone, statements);
  statements.push_back(
      {"INSERT INTO corbslam.pictures (mission_id, local_map, keyframe, ordinal, scale, size,"
       " checksum, bytes) SELECT $1, $2, $3, $4, $5, $6, $7, $8 FROM corbslam.missions"
       " WHERE mission_id = $1 AND epoch = $9 AND state = 0 ON CONFLICT DO NOTHING",
       {Id(), SqlValue::Bits(picture.keyframe.local_map.value),
        SqlValue::Number(picture.keyframe.index), SqlValue::Bits(added.order),
        SqlValue::Bits(std::bit_cast<uint64_t>(picture.scale)), SqlValue::Bits(bytes),
        SqlValue::Bits(PictureChecksum(picture.jpeg, added.order)), SqlValue::Bytes(picture.jpeg),
        SqlValue::Number(epoch)}});
  const absl::Status written = Name(pool_.WriteAgain(statements).status());
  if (written.ok()) return written;
  absl::MutexLock lock(&mutex_);
  pictures_.Take(picture.keyframe);
  for (const BookedPicture& oldest : gone) pictures_.Put(oldest);
  return written;
}

absl::StatusOr<KeyframePicture> PostgresMission::ReadPicture(KeyframeId keyframe) const {
  const auto read = pool_.Read(
      {{"SELECT ordinal, scale, checksum, bytes FROM corbslam.pictures"
        " WHERE mission_id = $1 AND local_map = $2 AND keyframe = $3",
        {Id(), SqlValue::Bits(keyframe.local_map.value), SqlValue::Number(keyframe.index)}}});
  RETURN_IF_ERROR(Name(read.status()));
  const SqlResult& found = read->front();
  if (found.rows() == 0) {
    return absl::NotFoundError(absl::StrCat("keyframe ", ToString(keyframe), " has no picture"));
  }
  KeyframePicture picture{keyframe, found.Text(0, 3), std::bit_cast<double>(found.Bits(0, 1))};
  if (PictureChecksum(picture.jpeg, found.Bits(0, 0)) == found.Bits(0, 2)) return picture;
  return Name(absl::DataLossError(
      absl::StrCat("the picture of keyframe ", ToString(keyframe), " is damaged")));
}

absl::Status PostgresMission::ForEachPicture(
    const std::function<absl::Status(const KeyframePicture& picture)>& visit) const {
  const auto read =
      pool_.Read({{"SELECT local_map, keyframe FROM corbslam.pictures"
                   " WHERE mission_id = $1 ORDER BY ordinal",
                   {Id()}}});
  RETURN_IF_ERROR(Name(read.status()));
  const SqlResult& found = read->front();
  for (int i = 0; i < found.rows(); ++i) {
    const auto picture =
        ReadPicture({{found.Bits(i, 0)}, static_cast<uint32_t>(found.Number(i, 1))});
    if (absl::IsNotFound(picture.status())) continue;
    RETURN_IF_ERROR(picture.status());
    RETURN_IF_ERROR(visit(*picture));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::map_store
