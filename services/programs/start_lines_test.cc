#include "services/programs/start_lines.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

TEST(StartLinesTest, SayWhoMayCall) {
  SecurityOptions security;
  EXPECT_EQ(DescribeServing(WithoutTls()), "without TLS, to everybody");
  security.ca_file = "ca.pem";
  EXPECT_EQ(DescribeServing(security), "with TLS, to certificates");
  security.token_key_file = "token.pub";
  EXPECT_EQ(DescribeServing(security), "with TLS, to certificates and tokens");
  security.ca_file.clear();
  EXPECT_EQ(DescribeServing(security), "with TLS, to tokens");
}

TEST(StartLinesTest, SayAsWhomItCalls) {
  SecurityOptions security;
  EXPECT_EQ(DescribeCalling(WithoutTls()), "without TLS");
  EXPECT_EQ(DescribeCalling(security), "with TLS");
  security.certificate_file = "alpha.pem";
  EXPECT_EQ(DescribeCalling(security), "with TLS, by certificate alpha.pem");
  security.token_file = "alpha.token";
  EXPECT_EQ(DescribeCalling(security),
            "with TLS, by certificate alpha.pem, by the token in alpha.token");
}

}  // namespace
}  // namespace corbslam::services
