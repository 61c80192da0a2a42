#include "services/security/token.h"

#include <openssl/err.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "services/security/ed25519.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::string_view kPrefix = "corbslam1.";
// A token holds a few dozen grants; a call's metadata must fit in 8 KiB altogether.
constexpr size_t kMaxTokenBytes = 6000;
constexpr size_t kMaxWordLength = 64;
constexpr size_t kIdBytes = 8;

const unsigned char* Bytes(absl::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

absl::Status NoToken(absl::string_view why) {
  return absl::UnauthenticatedError(absl::StrCat("the caller's token ", why));
}

// Reads what only newer tokens have.
absl::Status ParseNewerClaims(const nlohmann::json& json, TokenClaims& claims) {
  const auto bad = NoToken("has claims that can't be read");
  for (const auto& [field, text] : {std::pair("id", &claims.id), {"audience", &claims.audience}}) {
    if (!json.contains(field)) continue;
    if (!json[field].is_string()) return bad;
    *text = json[field].get<std::string>();
    if (!CheckTokenWord(field, *text).ok()) return bad;
  }
  if (!json.contains("issued")) return absl::OkStatus();
  if (!json["issued"].is_number_integer()) return bad;
  claims.issued = absl::FromUnixSeconds(json["issued"].get<int64_t>());
  return absl::OkStatus();
}

// Returns an id for a token that was signed without one.
std::string IdOfText(absl::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest;
  SHA256(Bytes(text), text.size(), digest.data());
  return absl::StrCat("sha256-", absl::BytesToHexString(absl::string_view(
                                     reinterpret_cast<const char*>(digest.data()), kIdBytes)));
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
  RETURN_IF_ERROR(ParseNewerClaims(json, claims));
  return claims;
}

// Returns the claims as they are signed.
nlohmann::json ToJson(const TokenClaims& claims) {
  nlohmann::json json = {{"grants", nlohmann::json::array()},
                         {"expires", absl::ToUnixSeconds(claims.expires)}};
  for (const Grant& grant : claims.grants) json["grants"].push_back(FormatGrant(grant));
  if (!claims.id.empty()) json["id"] = claims.id;
  if (claims.issued) json["issued"] = absl::ToUnixSeconds(*claims.issued);
  if (!claims.audience.empty()) json["audience"] = claims.audience;
  return json;
}

}  // namespace

absl::StatusOr<std::string> MakeTokenId() {
  std::array<unsigned char, kIdBytes> bytes;
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    ERR_clear_error();
    return absl::InternalError("the system gives no random numbers for a token's id");
  }
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

absl::Status CheckTokenWord(absl::string_view field, absl::string_view text) {
  const auto is_good = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-';
  };
  if (!text.empty() && text.size() <= kMaxWordLength && std::ranges::all_of(text, is_good)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is \"", absl::CHexEscape(text.substr(0, 200)), "\", must be 1 to ",
                   kMaxWordLength, " letters, digits, '_', '.' and '-'"));
}

absl::StatusOr<std::string> SignToken(const TokenClaims& claims,
                                      absl::string_view private_key_pem) {
  ASSIGN_OR_RETURN(const Ed25519Key key, ReadEd25519PrivateKey(private_key_pem));
  if (!claims.id.empty()) RETURN_IF_ERROR(CheckTokenWord("id", claims.id));
  if (!claims.audience.empty()) RETURN_IF_ERROR(CheckTokenWord("audience", claims.audience));
  const std::string text = absl::StrCat(kPrefix, absl::WebSafeBase64Escape(ToJson(claims).dump()));
  ASSIGN_OR_RETURN(const std::string signature, SignBytes(text, key));
  const std::string token = absl::StrCat(text, ".", absl::WebSafeBase64Escape(signature));
  if (token.size() <= kMaxTokenBytes) return token;
  return absl::InvalidArgumentError(absl::StrCat("the token has ", token.size(), " bytes for ",
                                                 claims.grants.size(), " grants, at most ",
                                                 kMaxTokenBytes, " are allowed"));
}

absl::StatusOr<TokenVerifier> TokenVerifier::FromPem(absl::string_view public_keys_pem) {
  TokenVerifier verifier;
  ASSIGN_OR_RETURN(verifier.keys_, ReadEd25519PublicKeys("token key", public_keys_pem));
  return verifier;
}

absl::StatusOr<TokenClaims> TokenVerifier::Read(absl::string_view token) const {
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
  for (const Ed25519Key& key : keys_) is_signed = is_signed || IsSignedBy(text, signature, key);
  if (!is_signed) return NoToken("is not signed by a key that this server trusts");
  ASSIGN_OR_RETURN(TokenClaims claims, ParseClaims(claims_text));
  if (claims.grants.empty()) return NoToken("grants nothing");
  if (claims.id.empty()) claims.id = IdOfText(text);
  return claims;
}

absl::Status CheckExpiry(const TokenClaims& claims, absl::Time now) {
  if (now < claims.expires) return absl::OkStatus();
  return NoToken(absl::StrCat("of ", Describe({claims.grants}), " expired at ",
                              absl::FormatTime(claims.expires, absl::UTCTimeZone())));
}

absl::StatusOr<Identity> TokenVerifier::Verify(absl::string_view token, absl::Time now) const {
  ASSIGN_OR_RETURN(TokenClaims claims, Read(token));
  RETURN_IF_ERROR(CheckExpiry(claims, now));
  return Identity{std::move(claims.grants), std::move(claims.id)};
}

}  // namespace corbslam::services
