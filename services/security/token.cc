#include "services/security/token.h"

#include <openssl/err.h>
#include <openssl/pem.h>

#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::string_view kPrefix = "corbslam1.";
// A token holds a few dozen grants; a call's metadata must fit in 8 KiB altogether.
constexpr size_t kMaxTokenBytes = 6000;

using KeyPtr = std::shared_ptr<EVP_PKEY>;
using DigestPtr = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;
using BioPtr = std::unique_ptr<BIO, decltype(&BIO_free)>;

BioPtr ReadFrom(absl::string_view pem) {
  return {BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free};
}

// Makes OpenSSL refuse a key behind a passphrase; else it would ask for it at the terminal.
int NoPassphrase(char*, int, int, void*) { return -1; }

bool IsEd25519(const KeyPtr& key) {
  return key != nullptr && EVP_PKEY_id(key.get()) == EVP_PKEY_ED25519;
}

const unsigned char* Bytes(absl::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

absl::StatusOr<std::string> Sign(absl::string_view text, const KeyPtr& key) {
  const DigestPtr digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  std::string signature(64, '\0');
  size_t size = signature.size();
  if (EVP_DigestSignInit(digest.get(), nullptr, nullptr, nullptr, key.get()) != 1 ||
      EVP_DigestSign(digest.get(), reinterpret_cast<unsigned char*>(signature.data()), &size,
                     Bytes(text), text.size()) != 1) {
    ERR_clear_error();
    return absl::InternalError("signing with the token key failed");
  }
  return signature;
}

bool IsSignedBy(absl::string_view text, absl::string_view signature, const KeyPtr& key) {
  const DigestPtr digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  const bool good = EVP_DigestVerifyInit(digest.get(), nullptr, nullptr, nullptr, key.get()) == 1 &&
                    EVP_DigestVerify(digest.get(), Bytes(signature), signature.size(), Bytes(text),
                                     text.size()) == 1;
  // A forged signature must not show up as an error of the next TLS handshake on this thread.
  ERR_clear_error();
  return good;
}

absl::Status NoToken(absl::string_view why) {
  return absl::UnauthenticatedError(absl::StrCat("the caller's token ", why));
}

absl::StatusOr<TokenClaims> ParseClaims(const std::string& text) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto bad = NoToken("has claims that can't be read");
  if (!json.is_object() || !json.contains("grants") || !json.contains("expires")) return bad;
  if (!json["grants"].is_array() || !json["expires"].is_number_integer()) return bad;
  TokenClaims claims;
  claims.expires = absl::FromUnixSeconds(json["expires"].get<int64_t>());
  for (const nlohmann::json& entry : json["grants"]) {
    if (!entry.is_string()) return bad;
    const absl::StatusOr<Grant> grant = ParseGrant(entry.get<std::string>());
    if (!grant.ok()) return NoToken(absl::StrCat("is bad: ", grant.status().message()));
    claims.grants.push_back(*grant);
  }
  return claims;
}

// Counts PEM's blocks, whatever they hold.
size_t CountBlocks(absl::string_view pem) {
  constexpr absl::string_view kBegin = "-----BEGIN ";
  size_t count = 0;
  for (size_t at = pem.find(kBegin); at != absl::string_view::npos; at = pem.find(kBegin, at + 1)) {
    ++count;
  }
  return count;
}

}  // namespace

absl::StatusOr<std::string> SignToken(const TokenClaims& claims,
                                      absl::string_view private_key_pem) {
  const BioPtr pem = ReadFrom(private_key_pem);
  const KeyPtr key(PEM_read_bio_PrivateKey(pem.get(), nullptr, NoPassphrase, nullptr),
                   EVP_PKEY_free);
  ERR_clear_error();
  if (!IsEd25519(key)) {
    return absl::InvalidArgumentError(
        "there is no Ed25519 private key without a passphrase; make one with: openssl genpkey "
        "-algorithm ed25519");
  }
  nlohmann::json json = {{"grants", nlohmann::json::array()},
                         {"expires", absl::ToUnixSeconds(claims.expires)}};
  for (const Grant& grant : claims.grants) json["grants"].push_back(FormatGrant(grant));
  const std::string text = absl::StrCat(kPrefix, absl::WebSafeBase64Escape(json.dump()));
  ASSIGN_OR_RETURN(const std::string signature, Sign(text, key));
  const std::string token = absl::StrCat(text, ".", absl::WebSafeBase64Escape(signature));
  if (token.size() <= kMaxTokenBytes) return token;
  return absl::InvalidArgumentError(absl::StrCat("the token has ", token.size(), " bytes for ",
                                                 claims.grants.size(), " grants, at most ",
                                                 kMaxTokenBytes, " are allowed"));
}

absl::StatusOr<TokenVerifier> TokenVerifier::FromPem(absl::string_view public_keys_pem) {
  TokenVerifier verifier;
  const BioPtr pem = ReadFrom(public_keys_pem);
  while (true) {
    KeyPtr key(PEM_read_bio_PUBKEY(pem.get(), nullptr, NoPassphrase, nullptr), EVP_PKEY_free);
    if (key == nullptr) break;
    if (!IsEd25519(key)) return absl::InvalidArgumentError("a token key is no Ed25519 key");
    verifier.keys_.push_back(std::move(key));
  }
  ERR_clear_error();
  if (!verifier.keys_.empty() && CountBlocks(public_keys_pem) > verifier.keys_.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("token key ", verifier.keys_.size() + 1, " can't be read"));
  }
  if (!verifier.keys_.empty()) return verifier;
  return absl::InvalidArgumentError(
      "there is no Ed25519 public key; make one with: openssl pkey -pubout");
}

absl::StatusOr<Identity> TokenVerifier::Verify(absl::string_view token, absl::Time now) const {
  if (token.size() > kMaxTokenBytes) return NoToken("is too long");
  const size_t dot = token.rfind('.');
  if (!absl::StartsWith(token, kPrefix) || dot < kPrefix.size()) return NoToken("is no token");
  const absl::string_view text = token.substr(0, dot);
  std::string signature;
  std::string claims_text;
  if (!absl::WebSafeBase64Unescape(token.substr(dot + 1), &signature) ||
      !absl::WebSafeBase64Unescape(text.substr(kPrefix.size()), &claims_text)) {
    return NoToken("is no token");
  }
  bool is_signed = false;
  for (const KeyPtr& key : keys_) is_signed = is_signed || IsSignedBy(text, signature, key);
  if (!is_signed) return NoToken("is not signed by a key that this server trusts");
  ASSIGN_OR_RETURN(TokenClaims claims, ParseClaims(claims_text));
  if (claims.grants.empty()) return NoToken("grants nothing");
  if (now >= claims.expires) {
    return NoToken(absl::StrCat("of ", Describe({claims.grants}), " expired at ",
                                absl::FormatTime(claims.expires, absl::UTCTimeZone())));
  }
  return Identity{std::move(claims.grants)};
}

}  // namespace corbslam::services
