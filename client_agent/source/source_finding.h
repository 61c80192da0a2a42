// Says what is wrong, or looks wrong, in what a source gives (docs/sources.md lists every code).
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_FINDING_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_FINDING_H_

#include <string>
#include <utility>
#include <vector>

namespace corbslam::client_agent {

enum class FindingLevel {
  kWarning,  // Improbable: the run goes on, unless the user is strict.
  kError,    // A contradiction: nothing right can come of it.
};

struct SourceFinding {
  FindingLevel level = FindingLevel::kWarning;
  // A stable word for programs and for searching, for example "times-repeat".
  std::string code;
  // A sentence: file, line or frame, value and limit, and what to do about it.
  std::string text;
};
using SourceFindings = std::vector<SourceFinding>;

// What a part of opening a sequence has to say.
struct SourceRemarks {
  // One sentence for each part of the sequence that is not played, with the reason.
  std::vector<std::string> left_out;
  SourceFindings findings;

  void Add(SourceFindings more) {
    for (SourceFinding& finding : more) findings.push_back(std::move(finding));
  }
  void Add(SourceRemarks more) {
    for (std::string& what : more.left_out) left_out.push_back(std::move(what));
    Add(std::move(more.findings));
  }
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_SOURCE_FINDING_H_
