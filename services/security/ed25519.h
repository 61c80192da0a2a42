// Reads Ed25519 keys, and signs and verifies bytes with them.
#ifndef CORBSLAM_SERVICES_SECURITY_ED25519_H_
#define CORBSLAM_SERVICES_SECURITY_ED25519_H_

#include <openssl/evp.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

using Ed25519Key = std::shared_ptr<EVP_PKEY>;

// Reads one private key without a passphrase, as `openssl genpkey -algorithm ed25519` makes.
absl::StatusOr<Ed25519Key> ReadEd25519PrivateKey(absl::string_view pem);
// Reads one or more public keys; `what` says in errors what they are of ("token key").
absl::StatusOr<std::vector<Ed25519Key>> ReadEd25519PublicKeys(absl::string_view what,
                                                              absl::string_view pem);

// Returns the signature, of 64 bytes.
absl::StatusOr<std::string> SignBytes(absl::string_view bytes, const Ed25519Key& private_key);
// Returns whether the signature of the bytes is of this key, private or public.
bool IsSignedBy(absl::string_view bytes, absl::string_view signature, const Ed25519Key& key);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_ED25519_H_
