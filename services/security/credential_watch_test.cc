#include "services/security/credential_watch.h"

#include <gtest/gtest.h>

#include <string>

namespace corbslam::services {
namespace {

// A watch of one source, which looks only when it is told to.
class CredentialWatchTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto read = [this] { return file_; };
    const auto take = [this](const std::string& content) {
      if (content == "broken") return absl::InvalidArgumentError("it is broken");
      taken_ = content;
      return absl::OkStatus();
    };
    ASSERT_TRUE(watch_.Add({Credential::kTokenKeys, read, take}).ok());
  }
  CredentialState State() { return watch_.states().at(0); }

  absl::StatusOr<std::string> file_ = std::string("first");
  std::string taken_;
  CredentialWatch watch_{absl::Hours(1)};
};

TEST_F(CredentialWatchTest, TakesWhatIsNewOnce) {
  EXPECT_EQ(taken_, "first");
  watch_.Poll();
  EXPECT_EQ(State().taken, 0u);
  file_ = "second";
  watch_.Poll();
  watch_.Poll();
  EXPECT_EQ(taken_, "second");
  EXPECT_EQ(State().taken, 1u);
}

// Key and certificate are written one after the other.
TEST_F(CredentialWatchTest, BearsWithAFileThatIsBadForAMoment) {
  file_ = absl::InvalidArgumentError("the key is another's");
  watch_.Poll();
  EXPECT_FALSE(State().refused);
  file_ = "second";
  watch_.Poll();
  EXPECT_EQ(taken_, "second");
  EXPECT_FALSE(State().refused);
}

TEST_F(CredentialWatchTest, KeepsTheOldWhileTheNewIsBad) {
  for (const absl::StatusOr<std::string>& bad :
       {absl::StatusOr<std::string>(absl::InvalidArgumentError("gone")),
        absl::StatusOr<std::string>("broken")}) {
    file_ = bad;
    watch_.Poll();
    watch_.Poll();
    EXPECT_TRUE(State().refused);
    EXPECT_EQ(taken_, "first");
  }
  file_ = "first";
  watch_.Poll();
  EXPECT_FALSE(State().refused);
  EXPECT_EQ(State().taken, 0u);
}

TEST_F(CredentialWatchTest, WhatIsBadAtTheStartIsNotWatched) {
  const auto read = [] { return absl::StatusOr<std::string>(absl::InvalidArgumentError("gone")); };
  const auto take = [](const std::string&) { return absl::OkStatus(); };
  EXPECT_FALSE(watch_.Add({Credential::kAuthorities, read, take}).ok());
  EXPECT_EQ(watch_.states().size(), 1u);
}

// A robot that starts with a certificate that has expired takes the new one when it comes.
TEST_F(CredentialWatchTest, WhatMayComeIsWatchedAndTaken) {
  absl::StatusOr<std::string> file = absl::InvalidArgumentError("has expired");
  std::string taken;
  CredentialWatch watch(absl::Hours(1));
  watch.AddOrWait({Credential::kCertificate, [&] { return file; },
                   [&](const std::string& content) {
                     taken = content;
                     return absl::OkStatus();
                   }});
  ASSERT_EQ(watch.states().size(), 1u);
  EXPECT_TRUE(watch.states()[0].refused);
  watch.Poll();
  EXPECT_EQ(taken, "");
  file = "new";
  watch.Poll();
  EXPECT_EQ(taken, "new");
  EXPECT_FALSE(watch.states()[0].refused);
  EXPECT_EQ(watch.states()[0].taken, 1u);
}

TEST_F(CredentialWatchTest, ThereIsAStateOfEachCredential) {
  EXPECT_EQ(CredentialStates().size(), 5u);
  watch_.Start();
  file_ = "second";
  watch_.Poll();
  const CredentialState state = CredentialStates().at(static_cast<size_t>(Credential::kTokenKeys));
  EXPECT_EQ(state.credential, Credential::kTokenKeys);
  EXPECT_EQ(state.taken, 1u);
  EXPECT_EQ(state.expires, absl::InfiniteFuture());
}

}  // namespace
}  // namespace corbslam::services
