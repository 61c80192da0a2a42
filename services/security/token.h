// Makes and verifies signed bearer tokens, for callers without a certificate of their own.
//
// A token is "corbslam1.CLAIMS.SIGNATURE": CLAIMS is JSON in URL-safe base 64 (grants, and when the
// token expires in seconds since 1970), SIGNATURE is an Ed25519 signature of everything before its
// dot. Servers hold public keys only: whoever reads a server's files can't make tokens.
#ifndef CORBSLAM_SERVICES_SECURITY_TOKEN_H_
#define CORBSLAM_SERVICES_SECURITY_TOKEN_H_

#include <openssl/evp.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "services/security/identity.h"

namespace corbslam::services {

struct TokenClaims {
  std::vector<Grant> grants;
  absl::Time expires;
};

// Signs the claims. `private_key_pem` holds one Ed25519 private key, as `openssl genpkey -algorithm
// ed25519` makes.
absl::StatusOr<std::string> SignToken(const TokenClaims& claims, absl::string_view private_key_pem);

// Verifies tokens by public keys. Copyable, thread-safe.
class TokenVerifier {
 public:
  // Reads one or more Ed25519 public keys; a token of any of them is good, so that keys can be
  // changed one after the other.
  static absl::StatusOr<TokenVerifier> FromPem(absl::string_view public_keys_pem);

  // Returns who shows the token. UNAUTHENTICATED for what is no token, is of an unknown key, or has
  // expired at `now`.
  absl::StatusOr<Identity> Verify(absl::string_view token, absl::Time now) const;

 private:
  std::vector<std::shared_ptr<EVP_PKEY>> keys_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_TOKEN_H_
