#include "map_store/postgres/pieces.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/checksum.h"

namespace corbslam::map_store {
namespace {

std::string BytesOfNumber(uint64_t number) {
  std::string bytes;
  for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<char>(number >> shift));
  return bytes;
}

}  // namespace

uint64_t ChecksumOf(const Piece& piece, uint64_t place) {
  const std::string head =
      BytesOfNumber(place) + BytesOfNumber(piece.number) + BytesOfNumber(piece.count);
  return ExtendCrc32c(ExtendCrc32c(0, head), {piece.bytes.data(), piece.bytes.size()});
}

std::vector<Piece> CutPieces(std::string_view bytes, uint64_t place) {
  const uint64_t count = std::max<uint64_t>(1, (bytes.size() + kPieceBytes - 1) / kPieceBytes);
  std::vector<Piece> pieces;
  for (uint64_t number = 0; number < count; ++number) {
    Piece piece{number, count, 0, bytes.substr(number * kPieceBytes, kPieceBytes)};
    piece.checksum = ChecksumOf(piece, place);
    pieces.push_back(piece);
  }
  return pieces;
}

absl::Status PieceJoiner::Add(const Piece& piece, uint64_t place) {
  if (piece.number != next_ || (next_ > 0 && piece.count != count_)) {
    return absl::DataLossError(absl::StrCat("piece ", next_, " is lost"));
  }
  if (piece.checksum != ChecksumOf(piece, place)) {
    return absl::DataLossError(
        absl::StrCat("piece ", piece.number, " does not fit its checksum: its bytes are damaged"));
  }
  count_ = piece.count;
  ++next_;
  bytes_.append(piece.bytes);
  return absl::OkStatus();
}

std::string PieceJoiner::Take() {
  next_ = count_ = 0;
  return std::exchange(bytes_, {});
}

}  // namespace corbslam::map_store
