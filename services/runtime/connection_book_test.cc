#include "services/runtime/connection_book.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using Id = ConnectionBook::Id;

TEST(ConnectionBookTest, TheOldestThatDidNothingMakesRoom) {
  ConnectionBook book;
  const ConnectionLimits limits = {.all = 3, .of_host = 3};
  for (Id id = 1; id <= 3; ++id) EXPECT_TRUE(book.Enter(id, "a", limits).taken);
  const ConnectionBook::Verdict verdict = book.Enter(4, "a", limits);
  EXPECT_TRUE(verdict.taken);
  EXPECT_EQ(verdict.makes_room, Id{1});
  EXPECT_EQ(book.size(), 3u);
}

TEST(ConnectionBookTest, WhoIsBusyStaysAndWhoEverWasGoesLater) {
  ConnectionBook book;
  const ConnectionLimits limits = {.all = 3, .of_host = 3};
  for (Id id = 1; id <= 3; ++id) book.Enter(id, "a", limits);
  book.Begin(1);
  book.Begin(2);
  book.End(2);
  EXPECT_EQ(book.Enter(4, "a", limits).makes_room, Id{3}) << "it never was busy";
  EXPECT_EQ(book.Enter(5, "a", limits).makes_room, Id{4});
  book.Begin(5);
  EXPECT_EQ(book.Enter(6, "a", limits).makes_room, Id{2});
  book.Begin(6);
  EXPECT_EQ(book.busy(), 3u);
  EXPECT_FALSE(book.Enter(7, "a", limits).taken) << "all are busy";
  book.End(1);
  EXPECT_EQ(book.Enter(8, "a", limits).makes_room, Id{1});
}

TEST(ConnectionBookTest, WhoSaidNothingMakesRoomBeforeWhoIsAboutToCall) {
  ConnectionBook book;
  const ConnectionLimits limits = {.all = 3, .of_host = 3};
  for (Id id = 1; id <= 3; ++id) book.Enter(id, "a", limits);
  book.Speak(1);
  book.Speak(2);
  book.Speak(77);
  EXPECT_EQ(book.Enter(4, "a", limits).makes_room, Id{3});
  EXPECT_EQ(book.Enter(5, "a", limits).makes_room, Id{4}) << "a crowd that says nothing";
  book.Speak(5);
  EXPECT_EQ(book.Enter(6, "a", limits).makes_room, Id{1}) << "none is silent";
  book.Begin(2);
  book.Speak(2);
  book.End(2);
  EXPECT_EQ(book.Enter(7, "a", limits).makes_room, Id{6});
}

TEST(ConnectionBookTest, AHostThatHasItsFillMakesRoomItself) {
  ConnectionBook book;
  const ConnectionLimits limits = {.all = 10, .of_host = 2};
  book.Enter(1, "b", limits);
  book.Enter(2, "a", limits);
  book.Enter(3, "a", limits);
  EXPECT_EQ(book.Enter(4, "a", limits).makes_room, Id{2}) << "b's is older, and stays";
}

TEST(ConnectionBookTest, OfAllTheHostWithMostMakesRoom) {
  ConnectionBook book;
  const ConnectionLimits limits = {.all = 4, .of_host = 4};
  book.Enter(1, "robot", limits);
  for (Id id = 2; id <= 4; ++id) book.Enter(id, "crowd", limits);
  EXPECT_EQ(book.Enter(5, "probe", limits).makes_room, Id{2});
  EXPECT_EQ(book.Enter(6, "crowd", limits).makes_room, Id{3});
  EXPECT_TRUE(book.contains(1));
  EXPECT_EQ(book.TakeIdlest(), Id{4});
}

TEST(ConnectionBookTest, AConnectionThatUsesAnOldNumberIsAnother) {
  ConnectionBook book;
  book.Enter(1, "a", {});
  book.Begin(1);
  book.Enter(1, "b", {});
  EXPECT_EQ(book.size(), 1u);
  EXPECT_EQ(book.busy(), 0u);
  book.Leave(1);
  book.Leave(1);
  EXPECT_EQ(book.size(), 0u);
  EXPECT_EQ(book.TakeIdlest(), std::nullopt);
}

TEST(ConnectionBookTest, ANetworkOfIpv6IsOneHost) {
  EXPECT_EQ(HostOfIp("10.0.0.7"), "10.0.0.7");
  EXPECT_EQ(HostOfIp("::ffff:10.0.0.7"), "10.0.0.7");
  EXPECT_EQ(HostOfIp("2001:db8::1:2"), "2001:db8::/64");
  EXPECT_EQ(HostOfIp("2001:db8::7:1:2:3"), HostOfIp("2001:db8::9"));
  EXPECT_EQ(HostOfIp("fe80::1%eth0"), "fe80::/64");
}

}  // namespace
}  // namespace corbslam::services
