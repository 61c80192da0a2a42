// Knows which cameras this program can play.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_LIVE_SOURCES_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_LIVE_SOURCES_H_

#include <string>

namespace corbslam::client_agent {

// Registers the kinds of live sources that the program was built with (docs/live.md).
void RegisterLiveSources();

// Returns a line for each kind of source, live or not: how it is named, what it plays, and what is
// missing where the program was built without it.
std::string ListSources();

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_LIVE_SOURCES_H_
