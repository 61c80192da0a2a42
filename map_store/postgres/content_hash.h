// Names bytes by what they are.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_CONTENT_HASH_H_
#define CORBSLAM_MAP_STORE_POSTGRES_CONTENT_HASH_H_

#include <openssl/sha.h>

#include <string>

#include "absl/strings/string_view.h"

namespace corbslam::map_store {

// Returns the 32 bytes of SHA-256.
inline std::string ContentHash(absl::string_view bytes) {
  std::string hash(SHA256_DIGEST_LENGTH, '\0');
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
         reinterpret_cast<unsigned char*>(hash.data()));
  return hash;
}

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_CONTENT_HASH_H_
