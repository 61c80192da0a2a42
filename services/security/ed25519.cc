#include "services/security/ed25519.h"

#include <openssl/err.h>
#include <openssl/pem.h>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

using DigestPtr = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;
using BioPtr = std::unique_ptr<BIO, decltype(&BIO_free)>;

BioPtr ReadFrom(absl::string_view pem) {
  return {BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free};
}

// Makes OpenSSL refuse a key behind a passphrase; else it would ask for it at the terminal.
int NoPassphrase(char*, int, int, void*) { return -1; }

bool IsEd25519(const Ed25519Key& key) {
  return key != nullptr && EVP_PKEY_id(key.get()) == EVP_PKEY_ED25519;
}

const unsigned char* BytesOf(absl::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
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

absl::StatusOr<Ed25519Key> ReadEd25519PrivateKey(absl::string_view pem) {
  const BioPtr bio = ReadFrom(pem);
  Ed25519Key key(PEM_read_bio_PrivateKey(bio.get(), nullptr, NoPassphrase, nullptr), EVP_PKEY_free);
  ERR_clear_error();
  if (IsEd25519(key)) return key;
  return absl::InvalidArgumentError(
      "there is no Ed25519 private key without a passphrase; make one with: openssl genpkey "
      "-algorithm ed25519");
}

absl::StatusOr<std::vector<Ed25519Key>> ReadEd25519PublicKeys(absl::string_view what,
                                                              absl::string_view pem) {
  std::vector<Ed25519Key> keys;
  const BioPtr bio = ReadFrom(pem);
  while (true) {
    Ed25519Key key(PEM_read_bio_PUBKEY(bio.get(), nullptr, NoPassphrase, nullptr), EVP_PKEY_free);
    if (key == nullptr) break;
    if (!IsEd25519(key)) {
      return absl::InvalidArgumentError(absl::StrCat("a ", what, " is no Ed25519 key"));
    }
    keys.push_back(std::move(key));
  }
  ERR_clear_error();
  if (!keys.empty() && CountBlocks(pem) > keys.size()) {
    return absl::InvalidArgumentError(absl::StrCat(what, " ", keys.size() + 1, " can't be read"));
  }
  if (!keys.empty()) return keys;
  return absl::InvalidArgumentError(
      "there is no Ed25519 public key; make one with: openssl pkey -pubout");
}

absl::StatusOr<std::string> SignBytes(absl::string_view bytes, const Ed25519Key& private_key) {
  const DigestPtr digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  std::string signature(64, '\0');
  size_t size = signature.size();
  if (EVP_DigestSignInit(digest.get(), nullptr, nullptr, nullptr, private_key.get()) != 1 ||
      EVP_DigestSign(digest.get(), reinterpret_cast<unsigned char*>(signature.data()), &size,
                     BytesOf(bytes), bytes.size()) != 1) {
    ERR_clear_error();
    return absl::InternalError("signing with the Ed25519 key failed");
  }
  return signature;
}

bool IsSignedBy(absl::string_view bytes, absl::string_view signature, const Ed25519Key& key) {
  const DigestPtr digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  const bool good = EVP_DigestVerifyInit(digest.get(), nullptr, nullptr, nullptr, key.get()) == 1 &&
                    EVP_DigestVerify(digest.get(), BytesOf(signature), signature.size(),
                                     BytesOf(bytes), bytes.size()) == 1;
  // A forged signature must not show up as an error of the next TLS handshake on this thread.
  ERR_clear_error();
  return good;
}

}  // namespace corbslam::services
