// A token key that is the same in every run, and signs whatever claims.
#ifndef CORBSLAM_TESTS_FUZZ_SIGNING_KEY_H_
#define CORBSLAM_TESTS_FUZZ_SIGNING_KEY_H_

#include <openssl/evp.h>
#include <openssl/pem.h>

#include <array>
#include <memory>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace corbslam::tests {

class SigningKey {
 public:
  SigningKey() {
    constexpr std::array<unsigned char, 32> kSecret = {1, 2, 3};
    key_.reset(
        EVP_PKEY_new_raw_private_key(EVP_PKEY_ED25519, nullptr, kSecret.data(), kSecret.size()),
        EVP_PKEY_free);
  }

  std::string Sign(absl::string_view claims) const {
    const std::string text = absl::StrCat("corbslam1.", absl::WebSafeBase64Escape(claims));
    const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(),
                                                                         EVP_MD_CTX_free);
    std::string signature(64, '\0');
    size_t size = signature.size();
    EVP_DigestSignInit(digest.get(), nullptr, nullptr, nullptr, key_.get());
    EVP_DigestSign(digest.get(), reinterpret_cast<unsigned char*>(signature.data()), &size,
                   reinterpret_cast<const unsigned char*>(text.data()), text.size());
    return absl::StrCat(text, ".", absl::WebSafeBase64Escape(signature));
  }

  std::string public_pem() const {
    const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new(BIO_s_mem()), BIO_free);
    PEM_write_bio_PUBKEY(bio.get(), key_.get());
    return ToText(bio.get());
  }
  std::string private_pem() const {
    const std::unique_ptr<BIO, decltype(&BIO_free)> bio(BIO_new(BIO_s_mem()), BIO_free);
    PEM_write_bio_PrivateKey(bio.get(), key_.get(), nullptr, nullptr, 0, nullptr, nullptr);
    return ToText(bio.get());
  }

 private:
  static std::string ToText(BIO* bio) {
    char* data = nullptr;
    const auto size = static_cast<size_t>(BIO_get_mem_data(bio, &data));
    return {data, size};
  }

  std::shared_ptr<EVP_PKEY> key_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FUZZ_SIGNING_KEY_H_
