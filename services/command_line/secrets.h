// Keeps secrets that stand in a flag's value from being printed.
#ifndef CORBSLAM_SERVICES_COMMAND_LINE_SECRETS_H_
#define CORBSLAM_SERVICES_COMMAND_LINE_SECRETS_H_

#include <string>

namespace corbslam::services {

// Returns the text with *** for what looks like a password: in rtsp://user:PASSWORD@camera, in
// user-pw=PASSWORD, as GStreamer's elements take it, and in password=, passphrase= and secret=. Of
// a text of more than 4,096 characters it returns only how many there are.
std::string HideSecrets(const std::string& text);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_COMMAND_LINE_SECRETS_H_
