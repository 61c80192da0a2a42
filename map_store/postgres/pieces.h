// Cuts bytes into pieces that rows of a database take well, each with a checksum that also says
// where it belongs, and joins them again.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_PIECES_H_
#define CORBSLAM_MAP_STORE_POSTGRES_PIECES_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace corbslam::map_store {

inline constexpr size_t kPieceBytes = 512 << 10;

struct Piece {
  uint64_t number = 0;  // From 0 on.
  uint64_t count = 1;   // Of all pieces.
  uint64_t checksum = 0;
  std::string_view bytes;
};

// Returns the pieces, at least one. `place` names what they are of among all of the mission's.
std::vector<Piece> CutPieces(std::string_view bytes, uint64_t place);
// Returns the piece's checksum (CRC-32C, over its place, number, count and bytes).
uint64_t ChecksumOf(const Piece& piece, uint64_t place);

// Joins the pieces of one thing. Not thread-safe.
class PieceJoiner {
 public:
  // Returns DATA_LOSS if the piece is not the next one, or not what it was.
  absl::Status Add(const Piece& piece, uint64_t place);
  bool is_whole() const { return count_ > 0 && next_ == count_; }
  bool is_empty() const { return next_ == 0; }
  // Returns the bytes, and begins anew.
  std::string Take();

 private:
  std::string bytes_;
  uint64_t next_ = 0;
  uint64_t count_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_PIECES_H_
