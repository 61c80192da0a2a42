#include "tests/bench/started_server.h"

#include <utility>

#include "services/programs/default_vocabulary.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::DefaultVocabularyPath;
using services::FindProgramBeside;

absl::StatusOr<StartedServer> StartServer(const std::string& name,
                                          std::vector<std::string> arguments,
                                          const std::string& log) {
  ASSIGN_OR_RETURN(const std::string path, FindProgramBeside(name));
  arguments.insert(arguments.begin(), {path, "--listen", "127.0.0.1:0", "--insecure"});
  StartedServer server;
  ASSIGN_OR_RETURN(server.process, ChildProcess::Start(name, arguments, log));
  ASSIGN_OR_RETURN(server.address, server.process->WaitForAddress(absl::Seconds(30)));
  return server;
}

absl::StatusOr<std::vector<RecordedUploads>> RecordAll(const std::vector<std::string>& sources) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const Vocabulary> vocabulary,
                   Vocabulary::Load(DefaultVocabularyPath()));
  std::vector<RecordedUploads> uploads;
  for (const std::string& source : sources) {
    ASSIGN_OR_RETURN(RecordedUploads recorded, RecordUploads(source, vocabulary));
    uploads.push_back(std::move(recorded));
  }
  return uploads;
}

}  // namespace corbslam::tests
