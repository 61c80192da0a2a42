// Makes and verifies signed bearer tokens, for callers without a certificate of their own.
//
// A token is "corbslam1.CLAIMS.SIGNATURE": CLAIMS is JSON in URL-safe base 64 (grants, and when the
// token expires in seconds since 1970; of newer tokens also their id, when they were issued, and
// for which server they are), SIGNATURE is an Ed25519 signature of everything before its dot.
// Servers hold public keys only: whoever reads a server's files can't make tokens.
#ifndef CORBSLAM_SERVICES_SECURITY_TOKEN_H_
#define CORBSLAM_SERVICES_SECURITY_TOKEN_H_

#include <openssl/evp.h>

#include <memory>
#include <optional>
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
  // 1 to 64 letters, digits, '_', '.' and '-', by which the token can be revoked. A token that was
  // signed without one is known by TokenVerifier::Read's.
  std::string id = {};
  std::optional<absl::Time> issued = {};
  // Name of the servers that it is for; empty: it is for all that trust its key.
  std::string audience = {};
};

// Returns a fresh id: 16 random hexadecimal digits. INTERNAL where the system has no random
// numbers.
absl::StatusOr<std::string> MakeTokenId();
// INVALID_ARGUMENT, naming `field`, unless the text can be a token's id or an audience.
absl::Status CheckTokenWord(absl::string_view field, absl::string_view text);

// Signs the claims. `private_key_pem` holds one Ed25519 private key, as `openssl genpkey -algorithm
// ed25519` makes.
absl::StatusOr<std::string> SignToken(const TokenClaims& claims, absl::string_view private_key_pem);

// Verifies tokens by public keys. Copyable, thread-safe.
class TokenVerifier {
 public:
  // Reads one or more Ed25519 public keys; a token of any of them is good, so that keys can be
  // changed one after the other.
  static absl::StatusOr<TokenVerifier> FromPem(absl::string_view public_keys_pem);

  // Returns what a token of a known key says, expired or not; `id` is never empty: of a token
  // without one it is "sha256-" and 16 digits of what was signed. UNAUTHENTICATED for what is no
  // token, is of an unknown key, or grants nothing.
  absl::StatusOr<TokenClaims> Read(absl::string_view token) const;
  // Returns who shows the token. UNAUTHENTICATED likewise, and for one that has expired at `now`.
  absl::StatusOr<Identity> Verify(absl::string_view token, absl::Time now) const;

 private:
  std::vector<std::shared_ptr<EVP_PKEY>> keys_;
};

// Returns UNAUTHENTICATED, naming grants and time, for claims that have expired at `now`.
absl::Status CheckExpiry(const TokenClaims& claims, absl::Time now);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_TOKEN_H_
