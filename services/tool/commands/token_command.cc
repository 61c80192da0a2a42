#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/security/pem_files.h"
#include "services/security/token.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/result.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

struct TokenArguments {
  std::string key;
  std::string mission;
  std::string role;
  std::string agent;
  std::string lifetime = "24h";
  std::string audience;
  std::string out;
};

// Writes a file that only its owner can read, also where one was that others could.
absl::Status WriteSecret(const std::string& text, const std::string& path) {
  ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path, AtomicFile::Old::kReplaced,
                                                       AtomicFile::Readers::kOwnerAlways));
  RETURN_IF_ERROR(file.Append(text));
  return file.FinishUnsynced();
}

absl::Status MakeToken(const TokenArguments& arguments) {
  absl::Duration lifetime;
  if (!absl::ParseDuration(arguments.lifetime, &lifetime) || lifetime < absl::Seconds(1) ||
      lifetime == absl::InfiniteDuration()) {
    return absl::InvalidArgumentError(absl::StrCat("--lifetime is \"", arguments.lifetime,
                                                   "\", must be at least 1s, as 90m or 720h"));
  }
  Grant grant = {.role = Role::kViewer, .mission = arguments.mission, .name = arguments.agent};
  ASSIGN_OR_RETURN(grant.role, ParseMissionRole(arguments.role));
  // The grant is parsed as the program that reads the token will parse it.
  RETURN_IF_ERROR(ParseGrant(FormatGrant(grant)).status());
  ASSIGN_OR_RETURN(const std::string key, ReadSecurityFile("--key", arguments.key));
  const absl::Time now = absl::Now();
  TokenClaims claims = {.grants = {grant}, .expires = now + lifetime};
  ASSIGN_OR_RETURN(claims.id, MakeTokenId());
  claims.issued = now;
  claims.audience = arguments.audience;
  ASSIGN_OR_RETURN(const std::string token, SignToken(claims, key));
  // Whoever has to revoke it needs the id.
  const std::string expires = absl::FormatTime(claims.expires, absl::UTCTimeZone());
  nlohmann::ordered_json json = {
      {"id", claims.id}, {"grant", FormatGrant(grant)}, {"expires", expires}};
  if (!WantsJson()) {
    std::fprintf(stderr, "token %s of %s, good until %s\n", claims.id.c_str(),
                 FormatGrant(grant).c_str(), expires.c_str());
  }
  if (arguments.out.empty()) {
    json["token"] = token;
    PrintResult(token + "\n", json);
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(WriteSecret(token + "\n", arguments.out));
  json["file"] = arguments.out;
  PrintResult("", json);
  return absl::OkStatus();
}

}  // namespace

void AddTokenCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<TokenArguments>();
  CLI::App* token = app.add_subcommand("token", "Make a signed token for a robot or a person");
  token->add_option("--key", arguments->key, "PEM file of the Ed25519 private key that signs")
      ->required();
  token->add_option("--mission", arguments->mission, "The mission; - means all")->required();
  token->add_option("--role", arguments->role, "agent, viewer or operator")->required();
  token
      ->add_option("--agent,--name", arguments->agent,
                   "The agent; - means all. Of a viewer or an operator: a name for the logs")
      ->required();
  token->add_option("--lifetime", arguments->lifetime, "How long it is good, as 90m or 720h")
      ->capture_default_str();
  token->add_option("--audience", arguments->audience,
                    "Name of the servers that it is for (--token-audience); without: all");
  token->add_option("--out", arguments->out, "File to write; else it is printed");
  token->callback([arguments, &chosen] { chosen = [arguments] { return MakeToken(*arguments); }; });
}

}  // namespace corbslam::services
