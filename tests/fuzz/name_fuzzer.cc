// Feeds what callers name: resources, grants, page tokens. What is accepted is written again the
// same.
#include <cstdlib>
#include <memory>
#include <string>

#include "map_store/view/page_tokens.h"
#include "services/convert/resource_names.h"
#include "services/security/identity.h"
#include "tests/fuzz/live_store.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using map_store::MapStore;
using map_store::PageRequest;
using services::AgentName;
using services::Describe;
using services::FormatGrant;
using services::IdentityFromUris;
using services::KeyframeName;
using services::LocalMapName;
using services::MissionName;
using services::ParseAgentName;
using services::ParseGrant;
using services::ParseKeyframeName;
using services::ParseLocalMapName;
using services::ParseMissionName;
using services::ParseMissionRole;

namespace {

void MustBe(bool good) {
  if (!good) std::abort();
}

void ReadNames(absl::string_view text) {
  if (const auto mission = ParseMissionName(text); mission.ok()) {
    MustBe(MissionName(*mission) == text);
  }
  if (const auto agent = ParseAgentName(text, false); agent.ok()) {
    MustBe(AgentName(agent->mission, agent->agent) == text);
  }
  (void)ParseAgentName(text, true);
  if (const auto all = ParseLocalMapName(text, true); all.ok()) {
    const auto one = ParseLocalMapName(text, false);
    MustBe(one.ok() == all->local_map.IsValid());
    if (one.ok()) MustBe(ParseLocalMapName(LocalMapName(one->mission, one->local_map), false).ok());
  }
  if (const auto keyframe = ParseKeyframeName(text); keyframe.ok()) {
    const auto again = ParseKeyframeName(KeyframeName(keyframe->mission, keyframe->keyframe));
    MustBe(again.ok() && again->keyframe == keyframe->keyframe);
  }
}

void ReadGrants(absl::string_view text) {
  if (const auto grant = ParseGrant(text); grant.ok()) MustBe(FormatGrant(*grant) == text);
  (void)ParseMissionRole(text);
  const std::string uri = std::string("corbslam:").append(text.data(), text.size());
  const auto identity = IdentityFromUris({"https://elsewhere", std::string(text), uri});
  if (identity.ok()) MustBe(!Describe(*identity).empty());
}

std::unique_ptr<MapStore> MakeStoreOfTwo() {
  auto store = MakeLiveStore();
  for (const char* agent : {"alpha", "bravo"}) {
    SessionRequest request;
    request.mission = "m";
    request.agent = agent;
    MustBe(store->OpenSession(request).ok());
  }
  return store;
}

// Reads pages of one item from this token on, which must come to an end.
template <typename List>
void ReadPages(const List& list, const std::string& token) {
  PageRequest request = {1, token};
  for (int pages = 0; pages < 4; ++pages) {
    const auto page = list(request);
    if (!page.ok()) return;
    MustBe(page->items.size() <= 1);
    request.page_token = page->next_page_token;
    if (request.page_token.empty()) return;
  }
  std::abort();
}

// Takes the text as a token, and as what a token of the list names.
template <typename List>
void ReadPagesOf(const std::string& name, const List& list, absl::string_view text) {
  ReadPages(list, std::string(text));
  ReadPages(list, map_store::MakePageToken({.list = name, .after = "", .size = 1}, text));
}

void ReadLists(absl::string_view text) {
  static const MapStore* const store = MakeStoreOfTwo().release();
  ReadPagesOf(
      "missions", [](const PageRequest& page) { return store->ListMissions(page); }, text);
  ReadPagesOf(
      "m/agents", [](const PageRequest& page) { return store->ListAgents("m", page); }, text);
  ReadPagesOf(
      "m/localMaps", [](const PageRequest& page) { return store->ListLocalMaps("m", page); }, text);
  ReadPagesOf(
      "m/keyframes/", [](const PageRequest& page) { return store->ListKeyframes("m", {}, page); },
      text);
  ReadPagesOf(
      "m/overlaps//", [](const PageRequest& page) { return store->ListOverlaps("m", {}, page); },
      text);
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  const absl::string_view text = AsText(data, size);
  ReadNames(text);
  ReadGrants(text);
  ReadLists(text);
  return 0;
}
