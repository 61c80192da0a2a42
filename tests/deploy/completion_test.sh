#!/usr/bin/env bash
# completion_test.sh PROGRAMS: what deploy/completion.bash offers for words of which the last is being typed, in a
# real bash, and in a real zsh where there is one.
set -euo pipefail
cd "$(dirname "$0")/../.."
programs=$1
fail() { echo "FAILED: $*" >&2; exit 1; }

# offers WANTED WORD...
# shellcheck disable=SC2016
offers() {
  local wanted=$1 shell
  shift
  set -- "$programs/$1" "${@:2}"
  for shell in bash "zsh -f"; do
    [ "$shell" = bash ] || command -v zsh >/dev/null || continue
    got=$($shell -c '[ -z "${ZSH_VERSION:-}" ] || { autoload -Uz compinit; compinit -D; }
      source deploy/completion.bash
      run() {
        [ -z "${ZSH_VERSION:-}" ] || { emulate -L sh; setopt kshglob noshglob braceexpand ksharrays; }
        COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)); _corbslam_complete; echo " ${COMPREPLY[*]} "
      }
      run "$@"' - "$@")
    [[ "$got" == *" $wanted "* ]] || fail "$shell, $*: offers$got, not $wanted"
  done
}

offers mission corbslam mi
offers settings corbslam mission s
offers --version corbslam --v
offers --server corbslam mission list --s
offers --format corbslam --config file mission export --fo
offers "tum" corbslam mission export --format t
offers sensor client_agent --pace s
offers --spool-sync-s client_agent --spool-s
offers "" client_agent --server ""
echo ok
