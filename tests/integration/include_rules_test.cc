#include "tests/integration/include_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "absl/strings/str_join.h"

namespace corbslam::tests {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(IncludeRulesTest, FindsWhatBreaksTheLayers) {
  const std::pair<const char*, const char*> forbidden[] = {
      {"slam/map/map.cc", "#include \"client_agent/map/guarded_map.h\"\n"},
      {"client_agent/agent/agent.cc", "#include \"map_store/store/map_store.h\"\n"},
      {"map_store/store/map_store.cc", "#include \"fusion_worker/local_fusion_worker.h\"\n"},
      {"fusion_worker/fuse.cc", "#include \"services/server/server.h\"\n"},
      {"map_store/store/map_store_test.cc", "#include \"fusion_worker/local_fusion_worker.h\"\n"},
      {"map_store/store/map_store.cc", "#include <grpcpp/grpcpp.h>\n"},
      {"map_store/records/journal.cc", "#include <prometheus/counter.h>\n"},
      {"slam/exchange/overlap.cc", "  #include \"corbslam/v1/overlap.pb.h\"\n"},
      {"client_agent/agent/agent.cc", "#include <google/protobuf/message.h>\n"},
      {"slam/camera/camera.cc", "#include \"slam/features/keypoint.h\"\n"},
      {"slam/map/map.h", "#include \"slam/matching/word_matching.h\"\n"},
      {"slam/matching/a.cc", "#include \"slam/solvers/triangulation.h\"\n"},
      {"slam/unheard_of/a.cc", "#include \"slam/util/ids.h\"\n"},
      {"client_agent/map/a.cc", "#include \"client_agent/mapping/mapper.h\"\n"},
      {"client_agent/source/source_spec.h", "#include \"services/simulation/lens.h\"\n"},
      {"services/programs/robot_program.cc", "#include \"services/simulation/lens.h\"\n"},
      {"services/simulation/scene.cc", "#include \"services/convert/ids.h\"\n"},
      {"services/programs/a.cc", "#include \"services/simulated_source/simulated_source.h\"\n"},
      {"map_store/state/mission_state.h", "#include \"map_store/store/map_store.h\"\n"},
      {"map_store/sharing/sharing.cc", "#include \"map_store/fusion/revision.h\"\n"},
      {"map_store/options/options.h", "#include \"map_store/state/lookups.h\"\n"},
      {"map_store/unheard_of.cc", "#include \"map_store/options/options.h\"\n"},
      // One mission and its fusion know nothing of a process's other missions.
      {"map_store/mission/a.cc", "#include \"map_store/process/memory_budget.h\"\n"},
      {"map_store/mission/a.h", "#include \"map_store/coordination/fusion_lanes.h\"\n"},
      {"map_store/coordination/a.h", "#include \"map_store/process/mission.h\"\n"},
      {"services/server/server.cc", "#include \"services/security/policy.h\"\n"},
      {"services/client/store/a.h", "#include \"services/tool/report/report.h\"\n"},
      {"services/client/remote/a.cc", "#include \"services/client/reachability/cause.h\"\n"},
      {"services/observe/observed_agent.h", "#include \"services/observe/metrics/families.h\"\n"},
      {"services/convert/ids.cc", "#include \"services/convert/work/work.h\"\n"},
      {"services/tool/unheard_of/a.cc", "#include \"services/server/server.h\"\n"},
      {"services/client/unheard_of.cc", "#include \"services/server/server.h\"\n"}};
  for (const auto& [path, text] : forbidden) {
    EXPECT_THAT(FindForbiddenIncludes(path, text), ElementsAre(HasSubstr(":1: includes")))
        << path << " " << text;
  }
}

TEST(IncludeRulesTest, LetsTheRestBe) {
  const std::pair<const char*, const char*> allowed[] = {
      {"services/server/server.cc",
       "#include <grpcpp/grpcpp.h>\n#include \"map_store/options/options.h\""},
      {"services/observe/metrics/families.h", "#include <prometheus/metric_family.h>\n"},
      {"slam/map/map.cc", "#include \"slam/map/map.h\"\n#include <vector>\n#include <Eigen/Core>"},
      {"services/observe/metrics/families.cc", "#include \"services/observe/observed_agent.h\"\n"},
      {"services/tool/commands/main.cc", "#include \"services/tool/run/plan.h\"\n"},
      {"services/tool/export/testing/a.h", "#include \"services/tool/run/plan.h\"\n"},
      {"map_store/fusion/revision.cc", "#include \"map_store/view/placement.h\"\n"},
      {"map_store/store/map_store_lists.cc", "#include \"map_store/process/mission.h\"\n"},
      {"map_store/state/a_test.cc", "#include \"map_store/store/map_store.h\"\n"},
      {"slam/matching/a_test.cc", "#include \"slam/optimisation/testing/synthetic_scene.h\"\n"},
      {"client_agent/a/b.cc", "// #include \"map_store/store/map_store.h\"\n"},
      {"docs/example.cc", "#include <grpcpp/grpcpp.h>\n"}};
  for (const auto& [path, text] : allowed) {
    EXPECT_THAT(FindForbiddenIncludes(path, text), IsEmpty()) << path;
  }
}

TEST(IncludeRulesTest, TheProjectKeepsThem) {
  const fs::path root = CORBSLAM_SOURCE_DIR;
  std::vector<std::string> forbidden;
  size_t files = 0;
  for (const char* top :
       {"slam", "client_agent", "map_store", "fusion_worker", "services", "tests"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".cc") continue;
      std::ifstream file(entry.path());
      std::stringstream text;
      text << file.rdbuf();
      const std::string path = fs::relative(entry.path(), root).generic_string();
      for (std::string& line : FindForbiddenIncludes(path, text.str())) {
        forbidden.push_back(std::move(line));
      }
      ++files;
    }
  }
  EXPECT_GT(files, 50u);
  EXPECT_THAT(forbidden, IsEmpty()) << absl::StrJoin(forbidden, "\n");
}

}  // namespace
}  // namespace corbslam::tests
