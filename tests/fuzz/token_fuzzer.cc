// Feeds what strangers show as a token, and the keys and certificates in an operator's files. The
// first byte says which.
#include <cstdlib>
#include <string>

#include "services/security/pem_files.h"
#include "services/security/token.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/messages.h"
#include "tests/fuzz/signing_key.h"

namespace corbslam::tests {

using services::FormatGrant;
using services::Grant;
using services::Identity;
using services::ParseGrant;
using services::ReadAuthorities;
using services::ReadKeyPair;
using services::Role;
using services::SignToken;
using services::TokenVerifier;

namespace {

void ReadToken(absl::string_view token) {
  static const TokenVerifier verifier = *TokenVerifier::FromPem(SigningKey().public_pem());
  const absl::StatusOr<Identity> identity = verifier.Verify(token, absl::UnixEpoch());
  if (!identity.ok()) return;
  for (const Grant& grant : identity->grants) {
    if (!(ParseGrant(FormatGrant(grant)).value() == grant)) std::abort();
  }
}

void ReadKeys(absl::string_view pem) {
  if (const auto verifier = TokenVerifier::FromPem(pem); verifier.ok()) {
    (void)verifier->Verify("corbslam1.e30.e30", absl::UnixEpoch());
  }
  (void)SignToken({{{Role::kViewer, "lab", "eve"}}, absl::UnixEpoch()}, pem);
}

void ReadFiles(absl::string_view input) {
  const std::string certificate = WriteFuzzFile("certificate.pem", TakeMessage(input));
  const std::string key = WriteFuzzFile("key.pem", TakeMessage(input));
  (void)ReadKeyPair(certificate, key);
  (void)ReadAuthorities(certificate);
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  if (size == 0) return 0;
  const absl::string_view input = AsText(data + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      ReadToken(input);
      break;
    case 1:
      ReadToken(SigningKey().Sign(input));
      break;
    case 2:
      ReadKeys(input);
      break;
    default:
      ReadFiles(input);
  }
  return 0;
}
